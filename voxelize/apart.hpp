// SPDX-License-Identifier: Apache-2.0
// Parts of a surface that are kept apart. Each is cut by itself; their grids stand side by side on
// one lattice, so that no two parts share a node or a voxel.

#pragma once

#include "voxelize/parts.hpp"

namespace elastogen {

/// Each part, cut by the lattice of the whole as if there were no others.
std::vector<CutBody> cut_parts(const CutBody& whole, const Parts& parts,
                               const VoxelizeOptions& options);

/// Distances along x by which bodies are moved so that they follow each other. Gaps are at least 32
/// voxels; distances are multiples of 64 voxels, so that bricks stay as they are.
/// @throws Error (resources) if the lattice is too short for them.
std::vector<int32_t> shifts_apart(const std::vector<CutBody>& bodies);

/// Sets parts, shifts and rest positions of nodes in a grid of bodies that were moved by `shift`.
void set_parts(const std::vector<CutBody>& bodies, std::vector<int32_t> shift, VoxelGrid& grid);

/// Part of each triangle of the surface, -1 if none of its vertices has one, (triangles).
Array<int32_t> part_of_triangles(const Surface& surface, const WeldedMesh& welded,
                                 const Parts& parts);

}  // namespace elastogen
