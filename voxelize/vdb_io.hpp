// SPDX-License-Identifier: Apache-2.0
// OpenVDB files: reads a level set or fog volume as a closed mesh, writes the voxels of a body.

#pragma once

#include "core/voxel_grid.hpp"
#include "io/asset.hpp"

#include <string>

namespace elastogen {

inline constexpr int64_t kMaxVdbVoxels = 1 << 25;  ///< active voxels of a grid that is read

/// Reads a grid in its world units: the one with the name, else the first (by name) float or point
/// data grid that is not empty. Further grids are a finding (vdb-grids). A float grid becomes a
/// closed mesh, a point data grid a cloud with its normals (N) and colours (Cd, linear); other
/// attributes are left out (lost-columns).
/// A level set has its surface at 0. A sharp density has it at half of its largest value, a ramp of
/// several voxels (as sdfToFogVolume makes them) where it falls to 0.
/// Only for the reader process: OpenVDB does not survive every damaged file.
/// @throws Error (asset) naming the grid: no such grid (listing the others), an empty one, more
///         than kMaxVdbVoxels voxels or points, a largest value that is not a positive number, no
///         surface; a file that is cut off.
Asset read_vdb(const std::string& path, const std::string& grid = "");

/// Writes the float grid "fill" (fog volume): the filled share of each voxel, 0 outside, at the
/// voxel's centre, in metres and the asset's axes; and the int32 grid "piece": the connected piece
/// of each voxel.
/// @param place  place of the grid's origin in the asset's coordinates [m].
/// @throws Error (resources) if the file cannot be written.
void write_vdb(const std::string& path, const VoxelGrid& grid, const Vec3& place = {});

}  // namespace elastogen
