// SPDX-License-Identifier: Apache-2.0
// Makes a grid from a set of voxels: order, nodes, tables, connected pieces.

#pragma once

#include "core/voxel_grid.hpp"

namespace elastogen {

/// Sorts voxels into 8x8x8 bricks (Morton order, x fastest inside) and fills coordinates, nodes,
/// corner and voxel tables, rest positions and pieces. All voxels are full: fill 1, shape_mean 1/8.
/// @param coords  lattice coordinates, (voxels, 3), no two alike; any order.
/// @throws Error  on duplicates, h <= 0, or coordinates outside +-2^20.
VoxelGrid make_grid(In<int32_t> coords, double h, const Vec3& origin);

class BrickIndex;

/// Only coordinates and tables, for voxels and for their corners in order.
VoxelGrid make_tables(const BrickIndex& voxels, const BrickIndex& nodes);

/// A full box of nx x ny x nz voxels; corner 0 of its first voxel lies at the origin.
VoxelGrid make_box(int nx, int ny, int nz, double h, const Vec3& origin = {});

}  // namespace elastogen
