// SPDX-License-Identifier: Apache-2.0
// The solver's view of an asset of any kind: a surface that bounds its solid, and the points that
// the solid carries.

#pragma once

#include "io/asset.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {

struct Body {
  Surface surface;        ///< [m]; of points and splats: made from them
  Array<double> carried;  ///< vertices, points or splats of the asset [m], (points, 3)
  double shell = 0;       ///< thickness of a solid that is a shell around points [m], else 0
  bool is_asset = true;   ///< the surface is the asset's own and carries its vertices
  std::vector<Finding> findings;
};

/// The body of an asset, scaled to a longest edge of `size` metres (0: as the file has it). Points
/// count without floaters, splats by shown_box. Solids of points: voxelize/from_points.hpp.
/// @param resolution  resolution of the later voxelisation: surfaces of points and splats are
///                    rebuilt from one point for each quarter of a voxel.
/// @throws Error (asset) if nothing can be made of it.
Body make_body(const Asset& asset, double size = 0, const VoxelizeOptions& resolution = {});

}  // namespace elastogen
