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
  if (scene.holder.empty()) return;
  nodes_.resize(scene.holders.size());
  dependent_.resize(scene.holders.size());
  for (int64_t n = 0; n < scene.pinned.rows(); ++n) {
    if (scene.pinned(n) != kPinnedNode || scene.holder(n) < 0) continue;
    nodes_[size_t(scene.holder(n))].push_back(int32_t(n));
    if (holder_of(n).moves()) moved_.push_back(int32_t(n));
  }
  bool follows = false;
  for (int64_t i = 0; i < scene.dependent.count(); ++i) {
    const int32_t holder = scene.holder(scene.dependent.node(i));
    if (holder < 0) continue;
    dependent_[size_t(holder)].push_back(int32_t(i));
    follows |= scene.holders[size_t(holder)].moves();
  }
  find_weights();
  place_.resize(moved_.size());
  if (follows) offset_.resize(size_t(scene.dependent.count()));
  set_time(0);
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

const Holder& HeldNodes::holder_of(int64_t node) const {
  return scene_.holders[size_t(scene_.holder(node))];
}

Vec3 HeldNodes::rest(int64_t node) const {
  return at(scene_.grid.rest.data(), node);
}

void HeldNodes::set_time(double time) {
  time_ = time;
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
}

void HeldNodes::follow(double* u) const {
  scene_.dependent.fill(u);
  for (size_t i = 0; i < offset_.size(); ++i) {
    const int32_t n = scene_.dependent.node(int64_t(i));
    set(u, n, plus(at(u, n), offset_[i]));
  }
}

void HeldNodes::set_velocities(const double* x, double* v) const {
  for (const int32_t n : moved_) set(v, n, held_velocity(holder_of(n), at(x, n), time_));
}

/// The point that moments are about [m].
Vec3 HeldNodes::centre(size_t holder, const double* u) const {
  if (scene_.holders[holder].turns) return scene_.holders[holder].centre;
  Vec3 sum = {};
  for (const int32_t n : nodes_[holder]) sum = plus(sum, plus(rest(n), at(u, n)));
  for (const int32_t i : dependent_[holder]) {
    const int32_t n = scene_.dependent.node(i);
    sum = plus(sum, plus(rest(n), at(u, n)));
  }
  return scaled(sum, 1 / double(nodes_[holder].size() + dependent_[holder].size()));
}

std::vector<Reaction> HeldNodes::reactions(const double* r, const double* u,
                                           const double* load) const {
  std::vector<Reaction> all(scene_.holders.size());
  for (size_t h = 0; h < nodes_.size(); ++h) {
    if (nodes_[h].empty() && dependent_[h].empty()) continue;
    Reaction& sum = all[h];
    sum.about = centre(h, u);
    const auto arm = [&](int64_t n) { return minus(plus(rest(n), at(u, n)), sum.about); };
    for (const int32_t n : nodes_[h]) {
      Vec3 force = minus(at(r, n), scaled(scene_.gravity, weighing_[size_t(n)]));
      if (load) force = minus(force, at(load, n));
      sum.force = plus(sum.force, force);
      sum.moment = plus(sum.moment, cross(arm(n), force));
    }
    for (const int32_t i : dependent_[h]) {
      const int32_t n = scene_.dependent.node(i);
      const Span<const int32_t> parents = scene_.dependent.parents(i);
      double share = 1;
      Vec3 lever = arm(n);
      for (int64_t k = 0; k < parents.rows; ++k) {
        const double w = scene_.dependent.weights(i)(k);
        share -= w;
        lever = minus(lever, scaled(arm(parents(k)), w));
      }
      sum.force = plus(sum.force, scaled(at(r, n), share));
      sum.moment = plus(sum.moment, cross(lever, at(r, n)));
    }
  }
  return all;
}

double HeldNodes::power(const std::vector<Reaction>& reactions) const {
  double sum = 0;
  for (size_t h = 0; h < reactions.size(); ++h) {
    const Holder& holder = scene_.holders[h];
    const Vec3 rate = rate_at(holder.path, time_);
    sum += dot(holder.turns ? reactions[h].moment : reactions[h].force, rate);
  }
  // held voxels
  for (size_t k = 0; k < moved_.size(); ++k) {
    const int32_t n = moved_[k];
    const Vec3 v = held_velocity(holder_of(n), plus(rest(n), place_[k]), time_);
    sum -= (scene_.mass(n) - weighing_[size_t(n)]) * dot(scene_.gravity, v);
  }
  return sum;
}

}  // namespace elastogen
