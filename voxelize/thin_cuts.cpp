// SPDX-License-Identifier: Apache-2.0
#include "voxelize/thin_cuts.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kLeft = 1e-9;  // share of its fill that a slice keeps
constexpr double kAcross =
    0.99;  // least component of a normal that stands across a layer of voxels

/// The voxel next to one along the normal of a border that leaves a slice of it, -1 if the border is
/// no face there, or a corner is free.
int64_t next_of_slice(const VoxelGrid& grid, const Border& border, int64_t voxel) {
  const double nearest = nearest_free(border) * grid.h;
  Vec3 centre = {};
  for (int c = 0; c < 8; ++c) {
    const double* X = grid.rest.row(grid.corners(voxel, c));
    if (distance(border, {X[0], X[1], X[2]}) >= nearest) return -1;
    for (size_t d = 0; d < 3; ++d) centre[d] += X[d] / 8;
  }
  const Vec3 normal = distance_gradient(border, centre);
  for (int d = 0; d < 3; ++d)
    if (std::abs(normal[size_t(d)]) > kAcross)
      return neighbour(grid, voxel, d, normal[size_t(d)] > 0);
  return -1;
}

}  // namespace

void join_thin_cuts(const std::vector<Border>& borders, Voxelized& result) {
  VoxelGrid& grid = result.grid;
  for (size_t k = 0; k < result.cut.size(); ++k) {
    const auto [voxel, border] = result.cut[k];
    const bool is_shared = (k > 0 && result.cut[k - 1].voxel == voxel) ||
                           (k + 1 < result.cut.size() && result.cut[k + 1].voxel == voxel);
    if (is_shared || borders[size_t(border)].radius > 0) continue;
    const int64_t next = next_of_slice(grid, borders[size_t(border)], voxel);
    if (next < 0) continue;
    if (grid.member(next) == 0) grid.member(next) = grid.fill(next);
    grid.fill(next) += (1 - kLeft) * grid.fill(voxel);
    grid.fill(voxel) *= kLeft;
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
