// SPDX-License-Identifier: Apache-2.0
// Distances of nodes from a border, levelled so that the mean of their interpolant over the border
// within a voxel is about 0, which that of the distance is not where the border is curved.

#pragma once

#include "core/voxel_grid.hpp"
#include "voxelize/border.hpp"

#include <unordered_map>

namespace elastogen {

class LevelledDistance {
 public:
  /// d - e: e_v = sum_c Nbar_vc d_c with the means of the shape functions over the border within each
  /// of the voxels, e_i its mean over the voxels of a node, weighted with the border's area, spread
  /// to two more rings of nodes by means. e is 0 for planes.
  LevelledDistance(const VoxelGrid& grid, const Border& border, const std::vector<int32_t>& voxels);

  double operator()(int32_t node) const;

 private:
  const VoxelGrid& grid_;
  const Border& border_;
  std::unordered_map<int32_t, double> excess_;  // e, by node
};

}  // namespace elastogen
