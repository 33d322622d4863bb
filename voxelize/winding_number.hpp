// SPDX-License-Identifier: Apache-2.0
// Generalised winding number of triangles (Jacobson et al. 2013) by a tree of dipoles (Barill et
// al. 2018): 1 inside a closed surface, 0 outside, in between for surfaces with holes.

#pragma once

#include "core/base.hpp"

#include <vector>

namespace elastogen {

class WindingNumber {
 public:
  struct Triangle {
    Vec3 corner[3];
  };

  explicit WindingNumber(std::vector<Triangle> triangles);

  /// w(q) = 1/(4 pi) sum of the signed solid angles of the triangles. Clusters farther away than
  /// three times their radius count as dipoles (error about 1e-2 near a closed surface).
  double operator()(const Vec3& q) const;

 private:
  struct Node {
    Vec3 centre = {};   ///< mean of the area
    Vec3 dipole = {};   ///< sum of the area vectors
    double radius = 0;  ///< of all corners about the centre
    int32_t first = 0, last = 0;
    int32_t right = -1;  ///< second child, the first one follows its parent; -1 for a leaf
  };
  int32_t build(int32_t first, int32_t last);
  Node summary(int32_t first, int32_t last) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

/// Signed solid angle / (4 pi) of a triangle seen from q (Van Oosterom and Strackee 1983).
double winding(const WindingNumber::Triangle& triangle, const Vec3& q);

}  // namespace elastogen
