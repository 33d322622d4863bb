// SPDX-License-Identifier: Apache-2.0
// Dependent nodes: the body beyond a border moves so that its field is 0 on the border. With d the
// distance from the border, n its gradient and e_k the neighbours ahead of a node (i + sign n_k), slopes
// a = u/d are carried along the normal,
//
//     a_i = sum_k |n_k| a(i + e_k) / sum_k |n_k|,   a_m = u_m/d_m at free nodes,   u_i = d_i a_i,
//
// which is exact for fields that are linear and 0 on the border, and for slopes that are linear along it.

#pragma once

#include "core/dependent_nodes.hpp"
#include "core/voxel_grid.hpp"
#include "voxelize/border.hpp"

namespace elastogen {

/// The corners of voxels in which a border holds something are dependent where they lie nearer to it
/// than nearest_free() edges, or behind it. A node belongs to the nearest of those borders. Distances
/// from curved borders are levelled: the interpolant of the distance itself is not 0 on them.
/// @param cut      voxels in which borders hold something.
/// @param pinned   nodes that are held already, (nodes, 1).
/// @param borders_of_nodes  gets the number of the border that each dependent node belongs to.
DependentNodes dependent_nodes(const VoxelGrid& grid, const std::vector<Border>& borders,
                               const std::vector<BorderVoxel>& cut, const Array<uint8_t>& pinned,
                               std::vector<int32_t>* borders_of_nodes = nullptr);

}  // namespace elastogen
