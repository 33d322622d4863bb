// SPDX-License-Identifier: Apache-2.0
// The sparse voxel grid that both solvers step on: topology and geometry, no material.

#pragma once

#include "core/array.hpp"
#include "core/base.hpp"

#include <vector>

namespace elastogen {

/// Active voxels of edge h on the lattice origin + h (i, j, k).
///
/// Voxels and nodes are sorted by the 8x8x8 brick of their lattice coordinate, bricks in Morton
/// order, x fastest inside a brick. Corner c = i + 2 j + 4 k of a voxel lies on the + side of axis
/// d when bit d of c is set.
struct VoxelGrid {
  double h = 0;      ///< voxel edge [m]
  Vec3 origin = {};  ///< position of lattice point (0, 0, 0) [m]

  // filled by voxelize/bricks
  Array<int32_t> voxel_coord;  ///< lattice coordinate of each voxel's corner 0, (voxels, 3)
  Array<int32_t> node_coord;   ///< lattice coordinate of each node, (nodes, 3)
  Array<int32_t> corners;      ///< node of each corner, (voxels, 8)
  Array<int32_t> voxels;       ///< voxel of which the node is corner c, (nodes, 8), -1 if none
  Array<double> rest;          ///< rest position [m], (nodes, 3)
  Array<int32_t> piece;  ///< connected piece (voxels that share a node) of each node, (nodes, 1)
  int pieces = 0;

  /// Parts that are kept apart (--part-pieces) stand apart on the lattice: a voxel of part p at
  /// coordinate (i, j, k) lies at origin + h (i - part_shift[p], j, k). Both empty: one part.
  Array<int32_t> part;  ///< of each voxel, (voxels, 1)
  std::vector<int32_t> part_shift;

  // filled by voxelize/fill_fraction
  Array<double> fill;        ///< filled share of each voxel after the floor of 0.02, (voxels, 1)
  Array<double> shape_mean;  ///< mean of each corner's shape function over the fill, (voxels, 8),
                             ///< rows sum to 1, 1/8 in a full voxel
  Array<double> member;      ///< beside borders of pins that cut voxels: share of the edge that the
                             ///< body fills across its thin axes; 0, or empty: it is `fill`
  double volume = 0;         ///< volume of the asset [m^3]; 0 where it has none (open sheets)
  Array<double> sheet;       ///< thickness / h of the layer in each voxel, 0 where there is none,
                             ///< (voxels, 1); empty where no thickness was given

  /// Shift of a voxel along x from its true position [voxels].
  int32_t shift_of(int64_t voxel) const {
    return part.empty() ? 0 : part_shift[size_t(part(voxel))];
  }
  int64_t voxel_count() const { return corners.rows(); }
  int64_t node_count() const { return rest.rows(); }
};

/// The neighbour of a voxel across its upper or lower face along an axis, -1 if there is none.
inline int32_t neighbour(const VoxelGrid& grid, int64_t voxel, int axis, bool upper) {
  const int bit = 1 << axis;
  const int corner = upper ? bit : 0;
  return grid.voxels(grid.corners(voxel, corner), upper ? 0 : bit);
}

/// Bit d: a voxel has no neighbours along axis d.
inline int thin_axes(const VoxelGrid& grid, int64_t voxel) {
  int thin = 0;
  for (int d = 0; d < 3; ++d)
    if (neighbour(grid, voxel, d, false) < 0 && neighbour(grid, voxel, d, true) < 0) thin |= 1 << d;
  return thin;
}

}  // namespace elastogen
