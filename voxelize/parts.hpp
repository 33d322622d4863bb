// SPDX-License-Identifier: Apache-2.0
// The parts of a surface: pieces that neither touch nor lie within one another, and the gaps
// between those whose voxels would be joined.

#pragma once

#include "voxelize/cut_body.hpp"

namespace elastogen {

/// Two parts nearer than their voxels can tell.
struct PartGap {
  int32_t triangle[2];  ///< one of each part, where they are nearest
  double distance;      ///< [voxel edges]
};

struct Parts {
  std::vector<int32_t> of;  ///< part of each triangle, numbered by their first triangles
  int32_t count = 0;
  std::vector<PartGap> gaps;  ///< the smallest of each two parts with voxels that share a node
};

/// Triangles that share a vertex are of one part; so are those that meet or come closer than the
/// weld tolerance, those that bound a solid only together, and what lies within a solid (a cavity).
/// @param all  also parts that share no node are asked whether one lies within the other.
Parts find_parts(const CutBody& body, bool all);

}  // namespace elastogen
