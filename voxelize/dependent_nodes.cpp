// SPDX-License-Identifier: Apache-2.0
#include "voxelize/dependent_nodes.hpp"

#include "core/bricks/index.hpp"
#include "core/vec3.hpp"
#include "voxelize/levelled_distance.hpp"
#include "voxelize/sloped_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace elastogen {
namespace {

constexpr double kEnoughAhead = 0.3;  // share of sum |n_k| that the axis neighbours must hold
constexpr double kNarrowCosine =
    0.309;  // cos of 72 degrees, the widest angle to the normal otherwise

class Builder {
 public:
  Builder(const VoxelGrid& grid, const std::vector<Border>& borders,
          const std::vector<BorderVoxel>& cut, const Array<uint8_t>& pinned)
      : grid_(grid), borders_(borders), pinned_(pinned), nodes_(grid.node_coord) {
    std::vector<std::vector<int32_t>> voxels(borders.size());
    for (const BorderVoxel& at : cut) voxels[size_t(at.border)].push_back(at.voxel);
    for (size_t b = 0; b < borders.size(); ++b) distance_.emplace_back(grid, borders[b], voxels[b]);
    for (const BorderVoxel& at : cut)
      for (int c = 0; c < 8; ++c) consider(grid.corners(at.voxel, c), at.border);
    std::erase_if(dependents_, [&](const auto& entry) {
      const SlopedNode& of = entry.second;
      return of.distance >= nearest(of.border);
    });
  }

  std::vector<int32_t> borders_of_nodes() const { return borders_of(dependents_); }

  DependentNodes build() {
    return follow_slopes(dependents_, [&](int32_t node, SlopedNode& of) { find_slope(node, of); });
  }

 private:
  double nearest(int32_t border) const { return nearest_free(borders_[size_t(border)]) * grid_.h; }

  /// Gives a corner of a cut voxel to the nearest border.
  void consider(int32_t node, int32_t border) {
    if (pinned_(node)) return;
    offer(dependents_, node, border, distance_[size_t(border)](node));
  }

  bool share_voxel(int32_t a, int32_t b) const {
    for (int k = 0; k < 8; ++k)
      for (int l = 0; l < 8; ++l)
        if (grid_.voxels(a, k) >= 0 && grid_.voxels(a, k) == grid_.voxels(b, l)) return true;
    return false;
  }

  /// Adds `weight` times the slope at a neighbour; false if it has none that the node may take.
  bool add_slope(int32_t node, const SlopedNode& of, const Coord& step, double weight,
                 std::map<int32_t, double>& slope) const {
    Coord at;
    for (size_t d = 0; d < 3; ++d) at[d] = grid_.node_coord(node, int(d)) + step[d];
    const auto m = int32_t(nodes_.find(at));
    if (m < 0 || pinned_(m) || !share_voxel(node, m)) return false;
    if (const auto other = dependents_.find(m); other != dependents_.end()) {
      const SlopedNode& ahead = other->second;
      if (!ahead.known || ahead.border != of.border || ahead.slope.empty()) return false;
      for (const auto& [parent, factor] : ahead.slope) slope[parent] += weight * factor;
      return true;
    }
    const double d = distance_[size_t(of.border)](m);
    if (d < nearest(of.border)) return false;
    slope[m] += weight / d;
    return true;
  }

  void find_slope(int32_t node, SlopedNode& of) {
    of.known = true;
    const Vec3 n =
        distance_gradient(borders_[size_t(of.border)],
                          {grid_.rest(node, 0), grid_.rest(node, 1), grid_.rest(node, 2)});
    double sum = 0, all = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
    // the neighbours ahead along the axes
    for (size_t k = 0; k < 3; ++k) {
      if (n[k] == 0) continue;
      Coord step = {};
      step[k] = n[k] > 0 ? 1 : -1;
      if (add_slope(node, of, step, std::abs(n[k]), of.slope)) sum += std::abs(n[k]);
    }
    // where too few have a slope, all neighbours in a cone about the normal
    if (sum < kEnoughAhead * all) {
      of.slope.clear();
      sum = 0;
      for (int k = 0; k < 27; ++k) {
        const Coord step = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const Vec3 way = {double(step[0]), double(step[1]), double(step[2])};
        const double cosine = k == 13 ? 0 : dot(way, n) / norm(way);
        if (cosine <= kNarrowCosine) continue;
        const double weight = std::pow(cosine, 4);
        if (add_slope(node, of, step, weight, of.slope)) sum += weight;
      }
    }
    for (auto& [parent, factor] : of.slope) factor /= sum;
  }

  const VoxelGrid& grid_;
  const std::vector<Border>& borders_;
  const Array<uint8_t>& pinned_;
  BrickIndex nodes_;
  std::vector<LevelledDistance> distance_;
  SlopedNodes dependents_;
};

}  // namespace

DependentNodes dependent_nodes(const VoxelGrid& grid, const std::vector<Border>& borders,
                               const std::vector<BorderVoxel>& cut, const Array<uint8_t>& pinned,
                               std::vector<int32_t>* borders_of_nodes) {
  if (cut.empty()) return {};
  Builder builder(grid, borders, cut, pinned);
  if (borders_of_nodes) *borders_of_nodes = builder.borders_of_nodes();
  return builder.build();
}

}  // namespace elastogen
