// SPDX-License-Identifier: Apache-2.0
// The filled share of each voxel, and where in the voxel it lies.

#pragma once

#include "voxelize/surface_cells.hpp"

#include <optional>

namespace elastogen {

/// Smallest fill fraction of a voxel that the surface touches.
inline constexpr double kMinFill = 0.02;

/// Full voxels (x, y, z), (x + 1, y, z), ... of one row.
struct Run {
  Coord first;
  int32_t length;
};

/// The fill of a surface, in units of the voxel edge.
struct Fill {
  Array<double> moment;   ///< int N_c over the inside of each surface cell, (cells, 8)
  std::vector<Run> full;  ///< inside voxels without surface
  double volume = 0;      ///< of the inside

  int64_t full_voxels() const;
};

/// Exact fill of a surface that bounds a solid, by the divergence theorem along the rows of x:
///
///     int_cell w N_c dV = ahead_c + F_jk / 2,    F_jk = sum of the fluxes of cells at smaller x,
///
///
/// where the winding number w is 1 inside. Between cells with surface F must be w/4 of an empty or
/// a full voxel.
///
/// @param sign  -1 if the surface is inside out.
/// @return no value if that fails: the surface has holes, overlaps or is badly wound.
std::optional<Fill> exact_fill(const SurfaceCells& cells, int sign);

/// Fill by the generalised winding number w of the surface without its sheets; inside is |w| > 1/2.
/// In each surface cell 8x8 lines run along the axis that its surface faces most. On a line the
/// inside is found exactly, from its crossings and one evaluation of w for each cell. Voxels
/// without surface are inside if their centre is.
///
/// @param max_voxels  @throws Error (resources) if more voxels are needed.
Fill winding_fill(const LatticeMesh& mesh, const SurfaceCells& cells, int64_t max_voxels);

}  // namespace elastogen
