// SPDX-License-Identifier: Apache-2.0
#include "voxelize/thin_cuts.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kLeft = 1e-9;    // share of its fill that a slice keeps
constexpr double kAcross = 0.99;  // least component of a normal across a layer of voxels

/// The voxel next to another one, -1 if there is none.
struct Next {
  int64_t voxel = -1;
  int axis = 0;
  bool upper = false;  ///< it lies above
};

/// Dependent nodes by their numbers in the grid.
class Followers {
 public:
  Followers(const DependentNodes& dependent, int64_t nodes)
      : dependent_(dependent), place_(size_t(nodes), -1) {
    for (int64_t i = 0; i < dependent.count(); ++i) place_[size_t(dependent.node(i))] = i;
  }
  /// Whether a node follows another one alone.
  bool follows(int32_t node, int32_t parent) const {
    const int64_t i = place_[size_t(node)];
    return i >= 0 && dependent_.parents(i).rows == 1 && dependent_.parents(i)(0) == parent;
  }

 private:
  const DependentNodes& dependent_;
  std::vector<int64_t> place_;
};

/// That along the normal of a border that leaves a slice of a voxel; none if a corner of the slice follows
/// others than the node on its line in the next layer.
Next next_of_slice(const VoxelGrid& grid, const Border& border, int64_t voxel,
                   const Followers& followers) {
  const double* first = grid.rest.row(grid.corners(voxel, 0));
  const double half = grid.h / 2;
  const Vec3 normal =
      distance_gradient(border, {first[0] + half, first[1] + half, first[2] + half});
  Next next;
  for (size_t d = 0; d < 3; ++d)
    if (std::abs(normal[d]) > kAcross) {
      next.axis = int(d), next.upper = normal[d] > 0;
      next.voxel = neighbour(grid, voxel, next.axis, next.upper);
    }
  if (next.voxel < 0) return {};
  for (int c = 0; c < 8; ++c) {
    const int bit = 1 << next.axis, ahead = next.upper ? c | bit : c & ~bit;
    if (!followers.follows(grid.corners(voxel, c), grid.corners(next.voxel, ahead))) return {};
  }
  return next;
}

/// Means of the next voxel's shape functions over a slice, by those of the slice's own: with t the
/// place along the axis from the far end of the slice's voxel, (1 - t, t) become (2 - t, t - 1).
void means_from_next(const double* own, const Next& next, double means[8]) {
  for (int c = 0; c < 8; ++c) {
    if (c >> next.axis & 1) continue;
    const int bit = 1 << next.axis, far = next.upper ? c : c | bit, near = next.upper ? c | bit : c;
    means[far] = 2 * own[far] + own[near];
    means[near] = -own[far];
  }
}

/// Adds a slice to the fill and the means of the next voxel, unless most of both lies in the slice.
void add_slice(int64_t voxel, const Next& next, VoxelGrid& grid) {
  double means[8];
  means_from_next(grid.shape_mean.row(voxel), next, means);
  const double slice = (1 - kLeft) * grid.fill(voxel), all = grid.fill(next.voxel) + slice;
  double* to = grid.shape_mean.row(next.voxel);
  for (int c = 0; c < 8; ++c) means[c] = to[c] + slice / all * (means[c] - to[c]);
  if (*std::min_element(means, means + 8) < 0) return;
  std::copy_n(means, 8, to);
  if (grid.member(next.voxel) == 0) grid.member(next.voxel) = grid.fill(next.voxel);
  grid.fill(next.voxel) = all;
  grid.fill(voxel) -= slice;
}

}  // namespace

void join_thin_cuts(const std::vector<Border>& borders, const std::vector<BorderVoxel>& cut,
                    const DependentNodes& dependent, VoxelGrid& grid) {
  if (dependent.empty()) return;
  const Followers followers(dependent, grid.node_count());
  for (size_t k = 0; k < cut.size(); ++k) {
    const auto [voxel, border] = cut[k];
    const bool is_shared =
        (k > 0 && cut[k - 1].voxel == voxel) || (k + 1 < cut.size() && cut[k + 1].voxel == voxel);
    if (is_shared || borders[size_t(border)].radius > 0) continue;
    const Next next = next_of_slice(grid, borders[size_t(border)], voxel, followers);
    if (next.voxel >= 0) add_slice(voxel, next, grid);
  }
}

void take_member(int64_t voxel, const Vec3& thickness, VoxelGrid& grid) {
  const int thin = thin_axes(grid, voxel);
  double share = 1;
  for (int d = 0; d < 3; ++d)
    if (thin >> d & 1) share *= thickness[size_t(d)];
  grid.member(voxel) = share;
}

}  // namespace elastogen
