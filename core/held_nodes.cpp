// SPDX-License-Identifier: Apache-2.0
#include "core/held_nodes.hpp"

#include "core/parallel.hpp"
#include "core/vec3.hpp"

#include <algorithm>

namespace elastogen {
namespace {

Vec3 at(const double* values, int64_t n) {
  return {values[3 * n], values[3 * n + 1], values[3 * n + 2]};
}
void set(double* values, int64_t n, const Vec3& value) {
  for (size_t d = 0; d < 3; ++d) values[3 * n + int64_t(d)] = value[d];
}

}  // namespace

HeldNodes::HeldNodes(const Scene& scene) : scene_(scene) {
  nodes_.resize(scene.holders.size());
  rates_.resize(nodes_.size());
  centres_.resize(nodes_.size());
  if (scene.holder.empty()) return;
  find_weights();
  // pinned nodes, then those that follow others
  for (int64_t n = 0; n < scene.pinned.rows(); ++n) {
    const int32_t holder = scene.holder(n);
    if (scene.pinned(n) != kPinnedNode || holder < 0) continue;
    nodes_[size_t(holder)].push_back({int32_t(n), -1, weighing_[size_t(n)]});
    if (!holder_of(n).moves()) continue;
    moved_.push_back(int32_t(n));
    holders_of_moved_.push_back(holder);
  }
  bool follows = false;
  for (int64_t i = 0; i < scene.dependent.count(); ++i) {
    const int32_t n = scene.dependent.node(i), holder = scene.holder(n);
    if (holder < 0) continue;
    nodes_[size_t(holder)].push_back({n, int32_t(i), {}});
    follows |= scene.holders[size_t(holder)].moves();
  }
  find_fixed();
  find_centres();
  place_.resize(moved_.size());
  if (follows) offset_.resize(size_t(scene.dependent.count()));
  set_time(0);
}

/// Fixed components, and the nodes that each holder holds along some axes.
void HeldNodes::find_fixed() {
  std::vector<int32_t> parent(size_t(scene_.fixed.rows()), -1);
  const std::vector<int32_t>& parents = scene_.dependent.folded().nodes;
  for (size_t k = 0; k < parents.size() && !parent.empty(); ++k)
    parent[size_t(parents[k])] = int32_t(k);
  for (int64_t n = 0; n < scene_.fixed.rows(); ++n) {
    for (int d = 0; d < 3; ++d) {
      const int32_t holder = scene_.fixed(n, d);
      if (holder < 0) continue;
      fixed_.push_back(int32_t(3 * n + d));
      std::vector<HeldNode>& nodes = nodes_[size_t(holder)];
      if (nodes.empty() || nodes.back().node != int32_t(n))
        nodes.push_back({int32_t(n), -1, weighing_[size_t(n)], parent[size_t(n)], 0});
      nodes.back().axes |= uint8_t(1 << d);
    }
  }
}

/// The mass that voxels with a node that is not pinned give each node.
void HeldNodes::find_weights() {
  const VoxelGrid& grid = scene_.grid;
  const double scale = volume_scale(grid) * grid.h * grid.h * grid.h;
  weighing_.assign(size_t(grid.node_count()), 0);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    bool is_held = true;
    for (int c = 0; c < 8; ++c) is_held &= scene_.pinned(grid.corners(v, c)) == kPinnedNode;
    const double mass =
        is_held ? 0 : scale * scene_.materials[size_t(scene_.material(v))].density * grid.fill(v);
    for (int c = 0; c < 8; ++c)
      weighing_[size_t(grid.corners(v, c))] += mass * grid.shape_mean(v, c);
  }
}

void HeldNodes::find_centres() {
  for (size_t h = 0; h < nodes_.size(); ++h) {
    Vec3 sum = {};
    for (const HeldNode& held : nodes_[h]) sum = plus(sum, rest(held.node));
    if (!nodes_[h].empty()) centres_[h] = scaled(sum, 1 / double(nodes_[h].size()));
    if (scene_.holders[h].turns) centres_[h] = scene_.holders[h].centre;
  }
}

const Holder& HeldNodes::holder_of(int64_t node) const {
  return scene_.holders[size_t(scene_.holder(node))];
}

Vec3 HeldNodes::rest(int64_t node) const {
  return at(scene_.grid.rest.data(), node);
}

void HeldNodes::set_time(double time) {
  time_ = time;
  for (size_t h = 0; h < rates_.size(); ++h) rates_[h] = holder_rate(scene_.holders[h], time);
  for_each(int64_t(moved_.size()), [&](int64_t k) {
    const int32_t n = moved_[size_t(k)];
    place_[size_t(k)] = held_displacement(holder_of(n), rest(n), time);
  });
  for_each(int64_t(offset_.size()), [&](int64_t i) {
    const int32_t n = scene_.dependent.node(i);
    Vec3& offset = offset_[size_t(i)];
    offset = {};
    if (scene_.holder(n) < 0 || !holder_of(n).moves()) return;
    const Span<const int32_t> parents = scene_.dependent.parents(i);
    const Span<const double> weights = scene_.dependent.weights(i);
    offset = held_displacement(holder_of(n), rest(n), time);
    for (int64_t k = 0; k < parents.rows; ++k)
      offset = minus(offset,
                     scaled(held_displacement(holder_of(n), rest(parents(k)), time), weights(k)));
  });
}

void HeldNodes::place_pinned(double* u) const {
  for (size_t k = 0; k < moved_.size(); ++k) set(u, moved_[k], place_[k]);
  fix(u);
}

void HeldNodes::follow(double* u) const {
  fill(u);
  for (size_t i = 0; i < offset_.size(); ++i) {
    const int32_t n = scene_.dependent.node(int64_t(i));
    set(u, n, plus(at(u, n), offset_[i]));
  }
}

void HeldNodes::add_start_rates(double soon, double* v) {
  set_time(0);
  const std::vector<Vec3> now = offset_;
  set_time(soon);
  for (size_t i = 0; i < offset_.size(); ++i) {
    const int32_t n = scene_.dependent.node(int64_t(i));
    set(v, n, plus(at(v, n), scaled(minus(offset_[i], now[i]), 1 / soon)));
  }
  set_time(0);
}

void HeldNodes::set_velocities(const double* x, double* v) const {
  for (size_t k = 0; k < moved_.size(); ++k)
    set(v, moved_[k], rates_[size_t(holders_of_moved_[k])].velocity(at(x, moved_[k])));
}

std::vector<Reaction> HeldNodes::reactions(const double* r, const double* u,
                                           const double* load) const {
  const HeldForces forces{
      scene_.grid.rest.data(),         u, r, load, scene_.gravity, scene_.dependent.filled().view(),
      scene_.dependent.folded().view()};
  std::vector<HolderSums> sums(nodes_.size());
  for (size_t h = 0; h < sums.size(); ++h)
    for (const HeldNode& held : nodes_[h]) forces.add(held, rates_[h], centres_[h], sums[h].data());
  return reactions(sums);
}

std::vector<Reaction> HeldNodes::reactions(const std::vector<HolderSums>& sums) const {
  std::vector<Reaction> all(sums.size());
  for (size_t h = 0; h < all.size(); ++h) {
    if (nodes_[h].empty()) continue;
    const HolderSums& of = sums[h];
    const Vec3 force = {of[0], of[1], of[2]}, moment = {of[3], of[4], of[5]};
    // the mean of the nodes goes along with them
    Vec3 motion = {};
    if (!scene_.holders[h].turns)
      motion = scaled({of[6], of[7], of[8]}, 1 / double(nodes_[h].size()));
    all[h] = {force, minus(moment, cross(motion, force)), plus(centres_[h], motion)};
  }
  return all;
}

double HeldNodes::power(const std::vector<Reaction>& reactions) const {
  double sum = 0;
  for (size_t h = 0; h < reactions.size(); ++h)
    sum += dot(rates_[h].turns ? reactions[h].moment : reactions[h].force, rates_[h].rate);
  // held voxels, and what goes into the kinetic energy of moved nodes
  for (size_t k = 0; k < moved_.size(); ++k) {
    const auto n = size_t(moved_[k]);
    const HolderRate& holder = rates_[size_t(holders_of_moved_[k])];
    const Vec3 x = plus(rest(moved_[k]), place_[k]), v = holder.velocity(x);
    sum -= (scene_.mass(moved_[k]) - weighing_[n]) * dot(scene_.gravity, v);
    sum -= weighing_[n] * dot(holder.acceleration(x), v);
  }
  return sum;
}

}  // namespace elastogen
