// SPDX-License-Identifier: Apache-2.0
// The place of the asset's vertices in the voxel grid, and how the grid moves them.

#pragma once

#include "core/array.hpp"
#include "core/voxel_grid.hpp"

namespace elastogen {

/// A voxel and trilinear weights for each vertex of a surface.
struct Embedding {
  Array<int32_t> voxel;   ///< (vertices, 1)
  Array<double> weights;  ///< of the voxel's corners, (vertices, 8), rows sum to 1
};

/// Finds for each point the voxel that holds it; a point outside all voxels (in a dropped sliver,
/// or an unreferenced vertex) takes the nearest voxel. Up to one voxel away along each axis its
/// weights continue those at the nearest point of that voxel linearly, so that affine motions are
/// carried exactly. From one to two voxels they fade to those at the nearest point, which they are
/// beyond: a stray moves as what is nearest to it, hence no farther than the farthest node.
/// @param points  [m], (points, 3), finite.
/// @param part    of each, (points), where pieces are kept apart: it takes a voxel of that part.
/// @throws Error  where the grid has parts and the points have none.
Embedding embed(const VoxelGrid& grid, In<double> points, In<int32_t> part);
/// The same of a grid without parts.
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

/// Deformation gradient at embedded points, of the same interpolant as deform_asset,
///
///     F_p = I + sum_c (x_c - X_c) (x) grad w_pc,
///
/// exactly I where the nodes are exactly at rest. Of a stray it is that of the place which stands
/// for it: it turns as what is nearest.
/// @param x         nodal positions [m], (nodes, 3).
/// @param gradient  result [-], row-major, (points, 9).
void deformation_gradient(const VoxelGrid& grid, const Embedding& embedding, In<double> x,
                          Out<double> gradient);

}  // namespace elastogen
