// SPDX-License-Identifier: Apache-2.0
// Distance of two triangles, and of two sets of triangles.

#pragma once

#include "core/base.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace elastogen {

/// Smallest squared distance between points of two triangles; 0 if they meet. Also valid for
/// triangles without area.
double triangle_gap2(const Vec3 a[3], const Vec3 b[3]);

/// A tree of boxes over triangles, halved along the longest edge.
class TriangleBoxes {
 public:
  explicit TriangleBoxes(std::vector<std::array<Vec3, 3>> triangles);

  const Box& whole() const { return nodes_[0].box; }

  struct Node {
    Box box;
    int32_t first = 0, last = 0;  ///< triangles in their order here
    int32_t right = -1;           ///< second child, the first one follows; -1 for a leaf
  };
  const Node& node(int32_t n) const { return nodes_[std::size_t(n)]; }
  const std::array<Vec3, 3>& triangle(int32_t place) const {
    return triangles_[std::size_t(place)];
  }
  /// Number of a triangle in the list from which the tree was made.
  int32_t number(int32_t place) const { return number_[std::size_t(place)]; }

 private:
  int32_t build(int32_t first, int32_t last);

  std::vector<std::array<Vec3, 3>> triangles_;
  std::vector<int32_t> number_;
  std::vector<Node> nodes_;
};

/// The distance of two sets, and a triangle of each that has it.
struct TriangleGap {
  int32_t first = 0, second = 0;
  double distance = 0;
};

/// The smallest distance, to 1 %. The search stops at any distance of at most `enough`.
TriangleGap nearest(const TriangleBoxes& a, const TriangleBoxes& b, double enough);

}  // namespace elastogen
