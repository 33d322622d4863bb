// SPDX-License-Identifier: Apache-2.0
// The solid whose surface a cloud of points samples.
//
// Balls around the points close the gaps between them. Everything that the outside does not reach
// is filled. The solid is eroded until half of the points lie outside: a morphological closing with
// a fitted depth, so that neither noise nor the dips between points bias the volume.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// A solid in the numbers of the points.
struct PointSolid {
  Array<double> vertices;    ///< (vertices, 3)
  Array<int32_t> triangles;  ///< closed, facing outwards, (triangles, 3)
  Box box;                   ///< of the points without floaters
  bool is_shell = false;     ///< nearly all points enclose nothing
  std::vector<Finding> findings;
};

/// The solid of a cloud.
///
/// The ball radius is 1.5 spacings (point_spacing.hpp); it is larger if else 10 % of the points
/// would bound nothing. Holes up to 2 radii are closed. Clusters of less than 0.5 % of the points
/// are left out (finding "floaters"). Points that bound no inside - open scans, sheets - get a
/// shell one radius thick (finding "shell"). Level sets have three voxels a radius; beyond about
/// 1.2 million points the radius grows instead of their number (finding "coarse"). Any number of
/// threads gives the same bits.
/// @param place  name of the cloud for messages.
/// @param grain  points in one cell of this edge become one point (thinned()), as the voxels cannot
///               resolve finer details; 0: all points.
/// @throws Error (asset) if all points lie in one place, a number is not finite, or parts lie
///         further apart than a million voxels.
PointSolid solid_of_points(const std::vector<Vec3>& points, const std::string& place,
                           double grain = 0);

}  // namespace elastogen
