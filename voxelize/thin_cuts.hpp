// SPDX-License-Identifier: Apache-2.0
// Voxels of which a face of a border leaves a slice so thin that all its corners depend on the next
// layer. The field is one linear piece over slice and next voxel: held to its own mean strain, the
// slice would lock the shear of a bent body. It counts in the next voxel, which has the same strain.

#pragma once

#include "voxelize/border.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {

/// Gives what such voxels are filled to the next ones along the normal, where these are in the grid.
/// @param result  with the voxels that borders cut (`cut`), ascending.
void join_thin_cuts(const std::vector<Border>& borders, Voxelized& result);

/// Fills VoxelGrid::member of voxels that borders cut.
/// @param thickness  mean length of what is left of them along each axis [voxel edges].
void take_member(int64_t voxel, const Vec3& thickness, VoxelGrid& grid);

}  // namespace elastogen
