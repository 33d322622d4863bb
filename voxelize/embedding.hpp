// SPDX-License-Identifier: Apache-2.0
// Places of points in the voxel grid, and their motion with the grid.

#pragma once

#include "core/array.hpp"
#include "core/voxel_grid.hpp"

namespace elastogen {

/// A voxel and trilinear weights for each point.
struct Embedding {
  Array<int32_t> voxel;   ///< voxel of each point, (points, 1)
  Array<double> weights;  ///< of the voxel's corners, (points, 8), rows sum to 1; all 0: it rests
};

/// Finds the voxel that holds each point. A point outside all voxels (in a dropped sliver, or an
/// unreferenced vertex) gets the nearest voxel. Up to one voxel away along each axis, its weights
/// continue those at the nearest point of that voxel linearly, so that affine motions are carried
/// exactly. From one to two voxels they fade to the weights at that nearest point, and stay there
/// beyond. A stray point thus moves as its nearest voxel, never farther than the farthest node. A
/// point of a part without voxels rests, in voxel 0.
/// @param points  [m], (points, 3), finite.
/// @param part    of each point, (points), if pieces are kept apart: its voxel is of that part.
/// @throws Error  if the grid has parts and the points have none.
Embedding embed(const VoxelGrid& grid, In<double> points, In<int32_t> part);
/// embed for a grid without parts.
Embedding embed(const VoxelGrid& grid, In<double> points);

/// Displacement of embedded points,
///
///     d_p = sum_c w_pc (x_c - X_c),
///
/// exactly zero where the nodes are exactly at rest.
/// @param x             nodal positions [m], (nodes, 3).
/// @param displacement  result [m], (points, 3).
void deform_asset(const VoxelGrid& grid, const Embedding& embedding, In<double> x,
                  Out<double> displacement);

/// Deformation gradient at embedded points, of the same interpolation as in deform_asset,
///
///     F_p = I + sum_c (x_c - X_c) (x) grad w_pc,
///
/// exactly I where the nodes are exactly at rest. A stray point has the gradient of the place whose
/// weights it has, so it turns as its nearest voxel.
/// @param x         nodal positions [m], (nodes, 3).
/// @param gradient  result [-], row-major, (points, 9).
void deformation_gradient(const VoxelGrid& grid, const Embedding& embedding, In<double> x,
                          Out<double> gradient);

}  // namespace elastogen
