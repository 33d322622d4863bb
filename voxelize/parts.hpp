// SPDX-License-Identifier: Apache-2.0
// The parts of a surface: pieces that neither touch nor lie within one another, and the gaps
// between parts whose voxels would be joined.

#pragma once

#include "voxelize/cut_body.hpp"

namespace elastogen {

/// Two parts that are too close for their voxels to separate.
struct PartGap {
  int32_t triangle[2];  ///< one of each part, where they are nearest
  double distance;      ///< [voxel edges]
};

struct Parts {
  std::vector<int32_t> of;  ///< part of each triangle, numbered by their first triangles
  int32_t count = 0;
  std::vector<PartGap> gaps;  ///< smallest gap of each two parts with voxels that share a node
};

/// Triangles that share a vertex belong to one part. So do triangles that meet or come closer than
/// the weld tolerance, triangles that bound a solid only together, and a solid and triangles
/// within it (a cavity).
/// @param all  also checks whether parts that share no node lie within each other.
Parts find_parts(const CutBody& body, bool all);

}  // namespace elastogen
