// SPDX-License-Identifier: Apache-2.0
// OpenVDB files: a level set or fog volume in as a closed mesh, the voxels of a body out.

#pragma once

#include "core/voxel_grid.hpp"
#include "io/asset.hpp"

#include <string>

namespace elastogen {

inline constexpr int64_t kMaxVdbVoxels = 1 << 25;  ///< active voxels of a grid that is read

/// The first float grid (by name) as a closed mesh in its world units; further grids are a finding.
/// A level set has its surface at 0. A density has it at half of its largest value where it is
/// sharp, and where it falls to 0 if it is a ramp of several voxels, as sdfToFogVolume makes them.
/// For the reader process only: OpenVDB does not survive every damaged file.
/// @throws Error (asset) naming the grid: no float grid, an empty one, more than kMaxVdbVoxels, a
///         largest value that is not a positive number, no surface.
Asset read_vdb(const std::string& path);

/// Writes the float grid "fill" (fog volume): the filled share of each voxel, 0 outside, at the
/// voxel's centre, in metres and the asset's axes; and the int32 grid "piece": the connected piece
/// of each voxel.
/// @param place  of the grid's zero in the asset's coordinates [m].
/// @throws Error (resources) if the file cannot be written.
void write_vdb(const std::string& path, const VoxelGrid& grid, const Vec3& place = {});

}  // namespace elastogen
