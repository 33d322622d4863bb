// SPDX-License-Identifier: Apache-2.0
// Voxels of which a face of a border leaves a slice so thin that all its corners depend on the next
// layer of nodes. The field is one linear piece over slice and next voxel: held to its own mean
// strain, the slice would lock the shear of a bent body. It counts in the next voxel, which has the
// same strain.

#pragma once

#include "core/dependent_nodes.hpp"
#include "core/voxel_grid.hpp"
#include "voxelize/border.hpp"

namespace elastogen {

/// Gives what such voxels are filled to the next ones along the normal.
/// @param cut  voxels that borders cut, ascending.
void join_thin_cuts(const std::vector<Border>& borders, const std::vector<BorderVoxel>& cut,
                    const DependentNodes& dependent, VoxelGrid& grid);

/// Fills VoxelGrid::member of voxels that borders cut.
/// @param thickness  mean length of what is left of them along each axis [voxel edges].
void take_member(int64_t voxel, const Vec3& thickness, VoxelGrid& grid);

}  // namespace elastogen
