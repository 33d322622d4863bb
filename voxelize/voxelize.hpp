// SPDX-License-Identifier: Apache-2.0
// Voxelises assets: the one call that other modules use.

#pragma once

#include "core/scene.hpp"
#include "io/asset.hpp"
#include "voxelize/border.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// Memory that a simulation needs for each voxel of a solid: grid, state and both solvers, as auto
/// may need both [bytes]. Measured 2150 to 2470 (stress size).
inline constexpr int64_t kBytesPerVoxel = 2560;

struct VoxelizeOptions {
  int voxels = 48;  ///< along the longest edge; ignored if h > 0
  double h = 0;     ///< voxel edge [m], 0: from voxels
  int64_t max_voxels = 64'000'000;
  int64_t max_memory = 0;                    ///< [bytes], 0: no limit
  int64_t bytes_per_voxel = kBytesPerVoxel;  ///< memory of a voxel that max_memory assumes
  /// planes that a layer of nodes should lie in (pins, floor) [m]; the first of an axis wins
  std::optional<double> align[3] = {};
  double thickness = 0;      ///< of sheets and shells [m], 0: that of a voxel, and of the shell
  double shell = 0;          ///< thickness of a surface that is a shell around points [m], else 0
  bool part_pieces = false;  ///< pieces that do not touch share no node, however near they are
  std::vector<Border> borders = {};  ///< what lies behind them is held
};

/// Two pieces of a surface that are too close for their voxels to separate.
struct PieceGap {
  int64_t triangle[2];  ///< one triangle of each piece, where they are nearest
  double distance;      ///< [m]
};

struct VoxelizeReport {
  bool closed = false;          ///< every edge has two faces (after welding)
  bool winding_number = false;  ///< the inside was found by the generalised winding number
  int64_t border_voxels = 0;
  int64_t thin_voxels = 0;        ///< filled by less than the floor of 0.02
  int64_t dropped_slivers = 0;    ///< voxels of slivers.hpp, not in the grid
  double volume = 0;              ///< of the fill [m^3]
  double sheet_thickness = 0;     ///< of sheets, or of the shell [m]; 0: there is none
  double sheet_volume = 0;        ///< of sheets or the shell [m^3]
  std::vector<PieceGap> gaps;     ///< gaps between pieces that the voxels join
  std::vector<Finding> findings;  ///< hinges, several pieces, ...
};

struct Voxelized {
  VoxelGrid grid;
  VoxelizeReport report;
  Array<int32_t> part;  ///< of each triangle of the surface, -1 if unknown; empty: one part
  /// Voxels with free material in which one of the borders holds something; the grid fits the others.
  std::vector<BorderVoxel> cut;
};

/// Voxelises a surface. Every voxel inside it or touched by it is active, except slivers that hold
/// nothing together (slivers.hpp); points in a sliver move with the nearest voxel. Fill and
/// shape-function means are exact integrals if the surface bounds a solid once. If it is open,
/// overlaps or is badly wound, they follow from the winding number (inside: |w| > 1/2). Sheets
/// become layers: full voxels, or as thick as options.thickness. A shell that is to be thinner than
/// it is has its fill scaled. What lies behind a border that the grid does not fit (border.hpp) is not
/// in the grid, and of voxels that it cuts only the free part counts, without a least fill. Pieces nearer than about a voxel are joined by common nodes, unless
/// options.part_pieces keeps them apart: then each part (parts.hpp) is cut and filled by itself.
/// Any number of threads gives the same bits.
/// @throws Error (resources) before any allocation if the voxel or memory budget would be exceeded,
///         with the need and an h that fits; (asset) if nothing is left to simulate.
Voxelized voxelize(const Surface& surface, const VoxelizeOptions& options = {});

/// Points on the surface for contact: its vertices, and points at most h/2 apart on large
/// triangles, each with its share of the area and the trilinear weights of its voxel.
SurfacePoints surface_points(const VoxelGrid& grid, const Surface& surface);

/// Fills the points of a wind: the centres of the surface's triangles, halved until no edge is longer
/// than a voxel's.
/// @param is_held  whether a centre is left out.
void add_wind_surface(const VoxelGrid& grid, const Surface& surface,
                      const std::function<bool(const Vec3&)>& is_held, Wind& wind);

}  // namespace elastogen
