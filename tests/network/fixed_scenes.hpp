// SPDX-License-Identifier: Apache-2.0
// Bodies that are held along some axes only (Scene::fixed).

#pragma once

#include "tests/network/moved_scenes.hpp"

namespace elastogen::test {

/// Fixes the component of an axis, by a holder of its own, at the free nodes that where(X) selects.
template <class Where>
void fix(Scene& scene, int axis, const Where& where) {
  const int64_t nodes = scene.grid.node_count();
  if (scene.holder.empty()) {
    scene.holder = Array<int32_t>(nodes);
    scene.holder.fill(-1);
  }
  if (scene.fixed.empty()) {
    scene.fixed = Array<int32_t>(nodes, 3);
    scene.fixed.fill(-1);
  }
  const auto holder = int32_t(scene.holders.size());
  scene.holders.push_back({});
  for (int64_t n = 0; n < nodes; ++n) {
    const double* X = scene.grid.rest.row(n);
    if (scene.pinned(n) == kFreeNode && where(Vec3{X[0], X[1], X[2]}))
      scene.fixed(n, axis) = holder;
  }
  finish_scene(scene);
}

/// Fixes it in the plane of nodes at a place along the axis.
inline void fix_plane(Scene& scene, int axis, double place) {
  fix(scene, axis,
      [&](const Vec3& X) { return std::abs(X[size_t(axis)] - place) < 1e-6 * scene.grid.h; });
}

/// A soft bar 0.2 x 0.2 m, of 1 m between pins at both ends; or its half up to its plane of symmetry.
inline Scene symmetric_bar(TimeScheme scheme, bool half) {
  const double length = half ? 0.5 : 1;
  std::vector<Border> ends = {half_space_border(true, 0)};
  if (!half) ends.push_back(half_space_border(false, 1));
  Scene scene = held_scene(box_surface({0, 0, 0}, {length, 0.2, 0.2}), ends, 0.05, {}, 1.0 / 60);
  scene.materials[0] = solid(2e5, 0.3);
  scene.scheme = scheme;
  finish_scene(scene);
  if (half) fix_plane(scene, 0, length);
  return scene;
}

/// A bar on its lowest plane, along which it slides; nodes that follow others depend on that plane too.
inline Scene on_rails(Scene scene) {
  const Array<double>& X = scene.grid.rest;
  double lowest = X(0, 2);
  for (int64_t n = 0; n < X.rows(); ++n) lowest = std::min(lowest, X(n, 2));
  scene.gravity[2] = 4;
  fix_plane(scene, 2, lowest);
  return scene;
}

inline Scene sliding_bar(TimeScheme scheme) {
  return on_rails(pulled_bar(scheme));
}

}  // namespace elastogen::test
