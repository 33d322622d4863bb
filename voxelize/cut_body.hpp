// SPDX-License-Identifier: Apache-2.0
// A body cut by the lattice: its surface, its inside, and the voxels that may stand for it.

#pragma once

#include "voxelize/fill_fraction.hpp"

namespace elastogen {

struct CutBody {
  Lattice lattice;
  LatticeMesh mesh;
  SurfaceCells cells;
  Fill fill;
  bool closed = false;          ///< every edge has two faces (after welding)
  bool winding_number = false;  ///< the fill follows from it
  bool all_sheets = false;      ///< the surface bounds nothing
  std::vector<uint8_t> kept;    ///< 1: the cell is a voxel, (cells)
  std::vector<uint8_t> layer;   ///< 1: part of a sheet, a full voxel, (cells)

  /// Filled share of a surface cell's voxel, before any floor.
  double share(int64_t cell) const;
  /// The kept cells in their order, then the voxels without surface, (voxels, 3).
  Array<int32_t> voxels() const;
};

/// Cuts a surface and keeps every cell that it touches. Repeats to the bit on any threads.
/// @throws Error as voxelize does.
CutBody cut_body(const Surface& surface, const VoxelizeOptions& options);

/// Keeps the slivers of slivers.hpp no longer. @return their count.
int64_t drop_slivers(CutBody& body);

}  // namespace elastogen
