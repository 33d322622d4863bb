// SPDX-License-Identifier: Apache-2.0
// Compiled without fused operations, like the CPU's source, so that motions equal its bit by bit.
#include "core/cuda/held_nodes.cuh"

#include <algorithm>
#include <numeric>

namespace elastogen::cuda {
namespace {

/// The nodes of each holder, then the pinned nodes of none; no lists where nothing is held.
std::vector<std::vector<HeldNode>> lists_of(const Scene& scene, const HeldNodes& held) {
  std::vector<std::vector<HeldNode>> lists = held.nodes();
  if (std::ranges::all_of(lists, [](const auto& list) { return list.empty(); })) return {};
  lists.emplace_back();
  for (int64_t n = 0; n < scene.pinned.rows(); ++n)
    if (scene.pinned(n) == kPinnedNode && scene.holder(n) < 0) lists.back().push_back({int32_t(n)});
  return lists;
}

std::vector<HeldNode> joined(const std::vector<std::vector<HeldNode>>& lists) {
  std::vector<HeldNode> all;
  for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

/// HeldNodes::fixed_axes of all nodes, or none.
std::vector<uint8_t> axes_of(const Scene& scene, const HeldNodes& held) {
  std::vector<uint8_t> axes(size_t(scene.fixed.rows()));
  for (size_t n = 0; n < axes.size(); ++n) axes[n] = held.fixed_axes(int64_t(n));
  return axes;
}

/// The places of the lists' entries where these are joined.
std::vector<std::vector<int32_t>> places_of(const std::vector<std::vector<HeldNode>>& lists) {
  std::vector<std::vector<int32_t>> places;
  int32_t next = 0;
  for (const auto& list : lists) {
    places.emplace_back(list.size());
    std::iota(places.back().begin(), places.back().end(), next);
    next += int32_t(list.size());
  }
  return places;
}

}  // namespace

DeviceHeldNodes::DeviceHeldNodes(const Scene& scene)
    : host_(scene),
      gravity_(scene.gravity),
      dependent_(scene.dependent),
      fixed_(host_.fixed()),
      axes_(axes_of(scene, host_)),
      moved_(host_.moved()),
      holders_of_moved_(host_.holders_of_moved()),
      place_(host_.places()),
      offset_(host_.offsets()),
      rates_(host_.rates()),
      nodes_(joined(lists_of(scene, host_))),
      centres_(host_.centres()),
      groups_(places_of(lists_of(scene, host_))),
      parts_(groups_.chunks()),
      sums_(groups_.count()) {}

void DeviceHeldNodes::set_time(double time) {
  if (!move()) return;
  host_.set_time(time);
  place_.upload(host_.places().data());
  offset_.upload(host_.offsets().data());
  rates_.upload(host_.rates().data());
}

template <class T>
void DeviceHeldNodes::fix(T* values) const {
  const int32_t* const fixed = fixed_.data();
  cuda::for_each(fixed_.size(), [=] __device__(int64_t k) { values[fixed[k]] = 0; });
}
template void DeviceHeldNodes::fix(float*) const;
template void DeviceHeldNodes::fix(double*) const;

void DeviceHeldNodes::place_pinned(double* u) const {
  const int32_t* const nodes = moved_.data();
  const Vec3* const place = place_.data();
  cuda::for_each(3 * moved_.size(), [=] __device__(int64_t k) {
    u[3 * int64_t(nodes[k / 3]) + k % 3] = place[k / 3][size_t(k % 3)];
  });
  fix(u);
}

void DeviceHeldNodes::follow(double* u) const {
  fix(u);
  if (offset_.size() > 0)
    dependent_.fill(u, offset_.data());
  else
    dependent_.fill(u);
}

void DeviceHeldNodes::set_velocities(const double* x, double* v) const {
  const int32_t *const nodes = moved_.data(), *const holder = holders_of_moved_.data();
  const HolderRate* const rates = rates_.data();
  cuda::for_each(moved_.size(), [=] __device__(int64_t k) {
    const int64_t n = nodes[k];
    const Vec3 velocity = rates[holder[k]].velocity(HeldForces::at(x, n));
    for (int64_t d = 0; d < 3; ++d) v[3 * n + d] = velocity[size_t(d)];
  });
}

void DeviceHeldNodes::start_reactions(const double* rest, const double* load, const double* u,
                                      double* r) {
  const HeldForces forces{rest, u, r, load, gravity_, dependent_.sums(), dependent_.parents()};
  const HeldNode* const nodes = nodes_.data();
  const Vec3* const centres = centres_.data();
  const HolderRate* const rates = rates_.data();
  const int64_t holders = centres_.size();
  DeviceSums* const to = sums_.data();
  groups_.sums(
      parts_,
      [=] __device__(int64_t h, int64_t k, DeviceSums & sum) {
        const HeldNode held = nodes[k];
        if (h < holders) forces.add(held, rates[h], centres[h], sum.value);
        if (held.dependent >= 0 || !held.is_whole()) return;
        for (int64_t d = 0; d < 3; ++d) r[3 * int64_t(held.node) + d] = 0;
      },
      [=] __device__(int64_t h, const DeviceSums& sum) { to[h] = sum; });
}

std::vector<Reaction> DeviceHeldNodes::reactions() const {
  std::vector<HolderSums> sums(size_t(centres_.size()));
  if (has_reactions())
    for (size_t h = 0; h < sums.size(); ++h)
      std::copy_n(sums_[int64_t(h)].value, kHolderSums, sums[h].begin());
  return host_.reactions(sums);
}

}  // namespace elastogen::cuda
