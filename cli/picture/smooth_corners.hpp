// SPDX-License-Identifier: Apache-2.0
// Which corners of a surface are lit by one normal: seams of textures do not show, edges do.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Normals of a surface: corners of one normal are lit by the mean of their triangles.
struct SmoothCorners {
  Array<int32_t> normal_of;  ///< of each corner, (triangles, 3)
  int64_t normals = 0;
};

/// Joins the corners at a vertex, welded across seams, of triangles that share an edge there, run
/// opposite ways along it and meet smoothly. With normals of the file: where they agree on both
/// sides. Without: at less than 40 degrees, or 70 where no edge of 40 degrees goes on at an end, as
/// on rough scans.
/// @param file_normals  unit or zero of each corner, (3 triangles, 3), or empty.
SmoothCorners smooth_corners(const Surface& surface,
                             const std::vector<std::array<float, 3>>& file_normals);

}  // namespace elastogen
