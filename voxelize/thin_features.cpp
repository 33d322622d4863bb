// SPDX-License-Identifier: Apache-2.0
#include "voxelize/thin_features.hpp"

#include "core/error.hpp"

#include <numeric>

namespace elastogen {
namespace {

/// The voxel above v along axis d, -1 if none: it has v's upper corners as its lower ones.
int32_t upper_neighbour(const VoxelGrid& grid, int64_t v, int d) {
  return grid.voxels(grid.corners(v, 1 << d), 0);
}

}  // namespace

int64_t hinge_count(const VoxelGrid& grid) {
  std::vector<int32_t> parent(grid.voxel_count());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  int64_t groups = grid.voxel_count();
  for (int32_t v = 0; v < grid.voxel_count(); ++v)
    for (int d = 0; d < 3; ++d) {
      const int32_t other = upper_neighbour(grid, v, d);
      if (other < 0) continue;
      const int32_t a = root(v), b = root(other);
      groups -= a != b;
      parent[std::max(a, b)] = std::min(a, b);
    }
  return groups - grid.pieces;
}

std::vector<Finding> check_grid(const VoxelGrid& grid) {
  std::vector<Finding> findings;
  if (grid.pieces > 1)
    findings.push_back({"loose-pieces", grid.pieces, "pieces are held together by nothing"});
  if (const int64_t hinges = hinge_count(grid); hinges > 0)
    findings.push_back({"hinges", hinges, "groups of voxels hang on an edge or a corner alone"});
  return findings;
}

}  // namespace elastogen
