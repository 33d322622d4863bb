// SPDX-License-Identifier: Apache-2.0
// The grid of edge 2h over a grid of edge h: each of its voxels has up to eight children. Trilinear
// functions of 2h are trilinear on every child, so that fills, means of shape functions and the
// prolongation P are exact.

#pragma once

#include "core/voxel_grid.hpp"
#include "core/zeroed.hpp"

#include <vector>

namespace elastogen {

struct CoarseGrid {
  VoxelGrid grid;
  Array<int32_t> children;  ///< fine voxel at each corner of a voxel, (voxels, 8), -1 if none
  Array<int32_t> parents;   ///< nodes whose mean P gives a fine node, (fine nodes, 8), repeated
  Array<int32_t> around;    ///< fine nodes at offsets -1, 0, 1 per axis, (nodes, 27), -1 if none
};

/// Number of the fine node at the place of a coarse one in a row of `around`.
inline constexpr int kSamePlace = 13;

/// The coarse grid of all voxels. Of the eight ways to lay it, the one that meets most nodes on the
/// rim of what is held; then the one of the fewest voxels. Pieces that share no node keep apart.
/// @param held  1 where something of a node is held, (nodes, 1).
CoarseGrid coarse_grid(const VoxelGrid& fine, In<uint8_t> held);

/// fine = P coarse, (nodes, 3).
void prolong(const CoarseGrid& coarse, const double* values, double* fine);

/// coarse = P^T fine, (nodes, columns).
void restrict_sum(const CoarseGrid& coarse, int columns, const double* fine, double* sums);

/// Nodal values of h on 2h: those at the same place; where there is none, the affine function that
/// fits the nodes of the voxels around best, which affine motions are carried by exactly.
class NodeFit {
 public:
  NodeFit() = default;
  NodeFit(const CoarseGrid& coarse, const VoxelGrid& fine);
  /// (fine nodes, 3) to (nodes, 3).
  void apply(const double* fine, double* values) const;

 private:
  std::vector<int64_t> begin_;  // first entry of each node, (nodes + 1)
  std::vector<int32_t> node_;   // fine nodes
  std::vector<double> weight_;
};

}  // namespace elastogen
