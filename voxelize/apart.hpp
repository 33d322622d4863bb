// SPDX-License-Identifier: Apache-2.0
// Parts of a surface that are kept apart: each is cut by itself, and they stand side by side on the
// lattice, so that no two share a node or a voxel.

#pragma once

#include "voxelize/parts.hpp"

namespace elastogen {

/// Each part cut by the lattice of the whole, as if the others were not there.
std::vector<CutBody> cut_parts(const CutBody& whole, const Parts& parts,
                               const VoxelizeOptions& options);

/// How far each body must be moved along x so that they follow each other with gaps of 32 voxels
/// and more, in steps of 64, which keep the bricks.
/// @throws Error (resources) if the lattice is too short for them.
std::vector<int32_t> shifts_apart(const std::vector<CutBody>& bodies);

/// Gives a grid of bodies so moved its parts and shifts, and its nodes their places.
void set_parts(const std::vector<CutBody>& bodies, std::vector<int32_t> shift, VoxelGrid& grid);

/// Part of each triangle of the surface, -1 where none of its vertices has one, (triangles).
Array<int32_t> part_of_triangles(const Surface& surface, const WeldedMesh& welded,
                                 const Parts& parts);

}  // namespace elastogen
