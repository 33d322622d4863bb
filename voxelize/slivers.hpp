// SPDX-License-Identifier: Apache-2.0
// Border voxels that hold next to nothing and hold nothing together.

#pragma once

#include "core/array.hpp"

#include <vector>

namespace elastogen {

/// Finds the slivers that a grid is better off without: they move at nearly no cost in energy, so
/// they slow the solvers down and carry nothing. A voxel counts as a sliver if its fill is below
/// kMinFill; or below 0.1, if at most one voxel that is left shares a face with it and one of fill
/// 0.1 and more a node (so that nothing thin is eaten from its ends). The body is all other voxels
/// that are left. A sliver goes if
///
///  1. it shares a node with the body, and each sliver that shares a node with it does so with one
///     of those voxels of the body: hairs and walls of slivers stay, with all of their roots;
///  2. the others that share a node with it are connected over nodes among themselves, so no piece
///     falls apart;
///  3. those that share a face with it are connected over faces among the voxels that share a face
///     or an edge with it, so no face is replaced by a hinge.
///
/// 2 and 3 hold for the voxels that are left and also for those of the body alone, so a wall of
/// slivers between two parts of it is not thinned out to a single one. The emptiest that may go
/// always goes next (in steps of 1e-4 of fill, of equal ones the first in the order of a
/// VoxelGrid), until none may. Then the slivers are found again among what is left, until no round
/// lets one go.
/// @param coords  lattice coordinates, (voxels, 3), no two alike; any order.
/// @param fill    share of each voxel that is filled, before any floor, (voxels, 1).
/// @throws Error on wrong shapes or coordinates outside +-2^20.
/// @return 1 for each voxel that goes, (voxels).
std::vector<uint8_t> find_slivers(In<int32_t> coords, In<double> fill);

}  // namespace elastogen
