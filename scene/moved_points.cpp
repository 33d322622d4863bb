// SPDX-License-Identifier: Apache-2.0
#include "scene/moved_points.hpp"

#include "network/contact/contact.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace elastogen {

void note_moved(const std::vector<HeldPoint>& behind, Setup& setup) {
  for (const auto& [point, holder] : behind) {
    const double* x = setup.scene.surface.position.row(point);
    if (setup.scene.holders[size_t(holder)].moves())
      setup.moved_points.push_back({{x[0], x[1], x[2]}, holder});
  }
}

void drop_moved(const std::vector<HeldPoint>& behind, Setup& setup) {
  note_moved(behind, setup);
  SurfacePoints& surface = setup.scene.surface;
  Array<uint8_t> is_dropped(surface.voxel.rows());
  for (const auto& [point, holder] : behind)
    is_dropped(point) = setup.scene.holders[size_t(holder)].moves();
  const auto keep = [&](auto& array) {
    int64_t kept = 0;
    for (int64_t p = 0; p < array.rows(); ++p)
      if (!is_dropped(p)) std::copy_n(array.row(p), array.cols(), array.row(kept++));
    auto rest = std::move(array);
    array = std::decay_t<decltype(array)>(kept, rest.cols());
    std::copy_n(rest.data(), array.size(), array.data());
  };
  keep(surface.voxel), keep(surface.weights), keep(surface.area), keep(surface.position);
}

std::string collider_in_the_way(const Setup& setup, double time) {
  if (setup.moved_points.empty()) return {};
  const double layer = contact_layer(setup.scene);
  for (const Collider& collider : setup.scene.colliders) {
    const Collider core = core_of(collider, layer);
    const Vec3 offset = offset_at(collider, time);
    for (const auto& [rest, holder] : setup.moved_points) {
      const Holder& move = setup.scene.holders[size_t(holder)];
      const Vec3 x = plus(rest, held_displacement(move, rest, time));
      if (proximity(core, offset, x).distance <= 0)
        return fmt::format("collider '{}' and a part that cannot give way run into each other: {}",
                           collider.name, move.name);
    }
  }
  return {};
}

}  // namespace elastogen
