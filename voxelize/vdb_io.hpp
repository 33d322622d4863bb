// SPDX-License-Identifier: Apache-2.0
// OpenVDB files: the voxels of a body out.

#pragma once

#include "core/voxel_grid.hpp"

#include <string>

namespace elastogen {

/// Writes the float grid "fill" (fog volume): the filled share of each voxel, 0 outside, at the
/// voxel's centre, in metres and the asset's axes.
/// @throws Error (resources) if the file cannot be written.
void write_vdb(const std::string& path, const VoxelGrid& grid);

}  // namespace elastogen
