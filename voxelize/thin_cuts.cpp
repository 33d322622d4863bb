// SPDX-License-Identifier: Apache-2.0
#include "voxelize/thin_cuts.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kLeft = 1e-9;  // share of its fill that a slice keeps
constexpr double kAcross =
    0.99;  // least component of a normal that stands across a layer of voxels

/// The voxel next to another one, -1 if there is none.
struct Next {
  int64_t voxel = -1;
  int axis = 0;
  bool upper = false;  ///< it lies above
};

/// That along the normal of a border that leaves a slice of a voxel; none if the border is no face
/// there, or a corner is free.
Next next_of_slice(const VoxelGrid& grid, const Border& border, int64_t voxel) {
  const double nearest = nearest_free(border) * grid.h;
  Vec3 centre = {};
  for (int c = 0; c < 8; ++c) {
    const double* X = grid.rest.row(grid.corners(voxel, c));
    if (distance(border, {X[0], X[1], X[2]}) >= nearest) return {};
    for (size_t d = 0; d < 3; ++d) centre[d] += X[d] / 8;
  }
  const Vec3 normal = distance_gradient(border, centre);
  for (int d = 0; d < 3; ++d)
    if (std::abs(normal[size_t(d)]) > kAcross) {
      const bool upper = normal[size_t(d)] > 0;
      return {neighbour(grid, voxel, d, upper), d, upper};
    }
  return {};
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

void join_thin_cuts(const std::vector<Border>& borders, Voxelized& result) {
  VoxelGrid& grid = result.grid;
  for (size_t k = 0; k < result.cut.size(); ++k) {
    const auto [voxel, border] = result.cut[k];
    const bool is_shared = (k > 0 && result.cut[k - 1].voxel == voxel) ||
                           (k + 1 < result.cut.size() && result.cut[k + 1].voxel == voxel);
    if (is_shared || borders[size_t(border)].radius > 0) continue;
    const Next next = next_of_slice(grid, borders[size_t(border)], voxel);
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
