// SPDX-License-Identifier: Apache-2.0
// A body cut by the lattice: its surface, its inside, and the cells that may become voxels.

#pragma once

#include "voxelize/fill_fraction.hpp"

namespace elastogen {

struct CutBody {
  WeldedMesh welded;  ///< its triangles are the first of mesh, in the same order
  Lattice lattice;
  LatticeMesh mesh;
  SurfaceCells cells;
  Fill fill;
  bool closed = false;          ///< every edge has two faces (after welding)
  bool balanced = false;        ///< faces run along every edge equally often in both directions
  bool winding_number = false;  ///< the fill was found by the winding number
  bool all_sheets = false;      ///< the surface bounds nothing
  std::vector<uint8_t> kept;    ///< 1: the cell is a voxel, (cells)
  std::vector<uint8_t> layer;   ///< 1: part of a sheet, (cells)
  double thickness = 0;         ///< of sheets [voxel edges]; 0: layers are full voxels
  double sheet_area = 0;        ///< [voxel edges^2]
  /// For each triangle of mesh behind those of welded: the triangle of the sheet whose prism it
  /// belongs to. Thick sheets are prisms, not layers.
  std::vector<int32_t> prism_of;

  /// The triangle of welded for a triangle of mesh: itself, or the one of its prism.
  int32_t welded_triangle(int32_t t) const {
    const auto count = int32_t(welded.triangles.rows());
    return t < count ? t : prism_of[size_t(t - count)];
  }
  /// Volume of a layer in a cell [voxels], at most what the solid leaves.
  double layer_volume(int64_t cell) const;
  /// Filled share of a surface cell's voxel, before the least fill is applied.
  double share(int64_t cell) const;
  /// Integrals of the shape functions over the filled part, (8); of a tiny part over the surface.
  void moments(int64_t cell, double* result) const;
  /// The kept cells in their order, then the voxels without surface, (voxels, 3).
  Array<int32_t> voxels() const;
};

/// Cuts a surface and keeps every cell that it touches. Any number of threads gives the same bits.
/// @param lattice  used if given; else one is chosen.
/// @throws Error as voxelize does.
CutBody cut_body(const Surface& surface, const VoxelizeOptions& options,
                 const std::optional<Lattice>& lattice = {});

/// Drops the slivers of slivers.hpp from the kept cells. @return their number.
/// @param stays  1 for cells that are none in any case, (cells); empty: there are none of them.
int64_t drop_slivers(CutBody& body, const std::vector<uint8_t>& stays = {});

}  // namespace elastogen
