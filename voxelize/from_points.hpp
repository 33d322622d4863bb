// SPDX-License-Identifier: Apache-2.0
// The solid that a cloud of points samples the surface of.
//
// Balls around the points close the gaps between them; what the outside does not reach is filled;
// the solid is eroded until half of the points lie outside (a morphological closing whose depth is
// fitted, so that neither noise nor the dips between points bias the volume).

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// A solid in the numbers of the points.
struct PointSolid {
  Array<double> vertices;    ///< (vertices, 3)
  Array<int32_t> triangles;  ///< closed, facing outwards, (triangles, 3)
  Box box;                   ///< of the points without floaters
  bool is_shell = false;     ///< next to all points enclose nothing
  std::vector<Finding> findings;
};

/// The solid of a cloud.
///
/// The ball radius is 1.5 spacings (point_spacing.hpp), more where 10 % of the points would bound
/// nothing without; holes up to 2 radii are closed. Clusters of less than 0.5 % of the points are
/// left out (finding "floaters"); around points that bound no inside - open scans, sheets - stands
/// a shell one radius thick (finding "shell"). Level sets have three voxels a radius; beyond some
/// 1.2 million points the radius grows instead of their number (finding "coarse"). The same bits
/// at any number of threads.
/// @param place  what messages call the cloud.
/// @param grain  points of one cell of this edge become one (thinned()): what the voxels cannot
///               tell apart need not be rebuilt; 0: all points.
/// @throws Error (asset) if fewer than two places are given, a number is not finite, or parts lie
///         further apart than a million voxels.
PointSolid solid_of_points(const std::vector<Vec3>& points, const std::string& place,
                           double grain = 0);

}  // namespace elastogen
