// SPDX-License-Identifier: Apache-2.0
// A body cut by the lattice: its surface, its inside, and the voxels that may stand for it.

#pragma once

#include "voxelize/fill_fraction.hpp"

namespace elastogen {

struct CutBody {
  WeldedMesh welded;  ///< its triangles are the first ones of mesh, in their order
  Lattice lattice;
  LatticeMesh mesh;
  SurfaceCells cells;
  Fill fill;
  bool closed = false;          ///< every edge has two faces (after welding)
  bool balanced = false;        ///< every edge is run as often one way as the other
  bool winding_number = false;  ///< the fill follows from it
  bool all_sheets = false;      ///< the surface bounds nothing
  std::vector<uint8_t> kept;    ///< 1: the cell is a voxel, (cells)
  std::vector<uint8_t> layer;   ///< 1: part of a sheet, (cells)
  double thickness = 0;         ///< of sheets [voxel edges]; 0: layers are full voxels
  double sheet_area = 0;        ///< [voxel edges^2]
  /// Triangle of the sheet of each triangle of mesh behind those of welded: thick sheets
  /// are no layers but prisms.
  std::vector<int32_t> prism_of;

  /// The triangle of welded that one of mesh is, or stands for.
  int32_t welded_triangle(int32_t t) const {
    const auto count = int32_t(welded.triangles.rows());
    return t < count ? t : prism_of[size_t(t - count)];
  }
  /// Volume of a layer in a cell [voxels], no more than fits beside the solid.
  double layer_volume(int64_t cell) const;
  /// Filled share of a surface cell's voxel, before any floor.
  double share(int64_t cell) const;
  /// Integrals of the shape functions over what fills it, (8); over the surface where that is
  /// next to nothing.
  void moments(int64_t cell, double* result) const;
  /// The kept cells in their order, then the voxels without surface, (voxels, 3).
  Array<int32_t> voxels() const;
};

/// Cuts a surface and keeps every cell that it touches. Repeats to the bit on any threads.
/// @param lattice  that is to be used; else it is chosen.
/// @throws Error as voxelize does.
CutBody cut_body(const Surface& surface, const VoxelizeOptions& options,
                 const std::optional<Lattice>& lattice = {});

/// Keeps the slivers of slivers.hpp no longer. @return their count.
int64_t drop_slivers(CutBody& body);

}  // namespace elastogen
