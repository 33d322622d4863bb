// SPDX-License-Identifier: Apache-2.0
// Border voxels that have nearly no fill and hold nothing together.

#pragma once

#include "core/array.hpp"

#include <vector>

namespace elastogen {

/// Finds slivers, without which a grid is better: moving them costs nearly no energy, so they slow
/// the solvers down and carry nothing. A voxel is a sliver if its fill is below kMinFill. It is
/// also one if its fill is below 0.1, at most one remaining voxel shares a face with it, and a
/// voxel of fill 0.1 or more shares a node with it (so that thin parts do not shrink from their
/// ends). All other remaining voxels are the body. A sliver is removed if
///
///  1. it shares a node with the body, and each sliver that shares a node with it also shares one
///  with
///     those voxels of the body: hairs and sheets of slivers stay, with all of their roots;
///  2. the other voxels that share a node with it are connected over nodes among themselves, so
///  that
///     no piece falls apart;
///  3. voxels that share a face with it are connected over faces among the voxels that share a face
///  or
///     an edge with it, so that no hinge replaces a face.
///
/// Rules 2 and 3 must hold for the remaining voxels and for those of the body alone, so that a
/// sheet of slivers between two parts of the body is not thinned out to a single voxel. The next
/// voxel to be removed is always the one of least fill (in steps of 1e-4, the first of equals in
/// the order of a VoxelGrid), until none is left. Then slivers are found again among the remaining
/// voxels, until a round removes none.
/// @param coords  lattice coordinates, (voxels, 3), no two alike; any order.
/// @param fill    filled share of each voxel, before the least fill is applied, (voxels, 1).
/// @throws Error on wrong shapes or coordinates outside +-2^20.
/// @return 1 for each voxel to remove, (voxels).
std::vector<uint8_t> find_slivers(In<int32_t> coords, In<double> fill);

}  // namespace elastogen
