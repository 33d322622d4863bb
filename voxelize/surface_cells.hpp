// SPDX-License-Identifier: Apache-2.0
// The surface cut into the voxels that it passes, and integrals over each part, from which the
// fill follows exactly.

#pragma once

#include "voxelize/lattice_mesh.hpp"

namespace elastogen {

/// Voxels that contain a part of the surface, sorted by z, then y, then x. N_c = X_i Y_j Z_k are
/// the trilinear shape functions in coordinates 0..1 of the voxel, S is the surface in it and n its
/// normal:
struct SurfaceCells {
  std::vector<Coord> coord;
  Array<double> ahead;             ///< -int_S n_x (int_x^1 N_c dx') dA, (cells, 8)
  Array<double> flux;              ///< -int_S n_x Y_j Z_k dA, (cells, 4), column j + 2 k
  Array<double> area;              ///< int_S N_c dA, (cells, 8); sheets included
  std::vector<double> sheet_area;  ///< of sheets alone
  std::vector<uint8_t> touched;    ///< 1: part of the surface lies more than 1e-5 inside
  std::vector<uint8_t> side;       ///< bit 2 d (+1): part lies in the lower (upper) face of axis d
  std::vector<uint8_t> sheet;      ///< 1: touched by a sheet
  std::vector<int64_t> first;      ///< of the triangles of each cell, (cells + 1)
  std::vector<int32_t> triangle;   ///< triangles of the cells, ascending in each

  int64_t count() const { return static_cast<int64_t>(coord.size()); }
};

/// Cuts every triangle at the lattice planes. The parts of a triangle are an exact partition of it
/// (a part in a lattice plane belongs to the upper voxel). Any number of threads gives the same
/// bits.
SurfaceCells cut_surface(const LatticeMesh& mesh);

}  // namespace elastogen
