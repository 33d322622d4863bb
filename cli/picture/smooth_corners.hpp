// SPDX-License-Identifier: Apache-2.0
// Corners of a surface that share a normal for lighting: edges show, seams of textures do not.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Normals of a surface. Corners with one normal are lit by the mean of their triangles.
struct SmoothCorners {
  Array<int32_t> normal_of;  ///< of each corner, (triangles, 3)
  int64_t normals = 0;
};

/// Joins the corners at a vertex (welded across seams) of triangles that share an edge there, run
/// along it in opposite directions and meet smoothly. With normals of the file: if these agree on
/// both sides. Without: at less than 40 degrees, or at less than 70 if at one end of the edge no
/// edge of 40 degrees or more continues it, as on rough scans.
/// @param file_normals  for each corner a unit or zero vector, (3 triangles, 3), or empty.
SmoothCorners smooth_corners(const Surface& surface,
                             const std::vector<std::array<float, 3>>& file_normals);

}  // namespace elastogen
