// SPDX-License-Identifier: Apache-2.0
#include "voxelize/mesh_edges.hpp"

#include <algorithm>

namespace elastogen {

Edges find_edges(const std::vector<Coord>& triangles) {
  std::vector<HalfEdge> half;
  half.reserve(3 * triangles.size());
  for (size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      half.push_back({std::min(a, b), std::max(a, b), static_cast<int32_t>(t), a < b});
    }
  std::sort(half.begin(), half.end());

  Edges edges;
  for (size_t first = 0, last; first < half.size(); first = last) {
    for (last = first; last < half.size() && half[last].lower == half[first].lower &&
                       half[last].upper == half[first].upper;)
      ++last;
    if (last - first == 1) edges.border.push_back(half[first]);
    for (size_t i = first + 1; i < last; ++i)
      (last - first == 2 ? edges.manifold : edges.branching)
          .push_back(
              {{half[first].triangle, half[i].triangle}, half[first].forward == half[i].forward});
  }
  return edges;
}

}  // namespace elastogen
