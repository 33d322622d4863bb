// SPDX-License-Identifier: Apache-2.0
// Nodal fields of quadratic tetrahedra with curved edges at any point of the body.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

#include <vector>

namespace elastogen::test {

class TetField {
 public:
  /// The mesh (tet10) must outlive the field.
  explicit TetField(const fem::ElementMesh& mesh);

  /// Value of a nodal field, u (nodes, 3), at X [m], by the shape functions of the element that
  /// holds X: X = sum_a N_a(xi) X_a is solved for xi by Newton's method.
  /// @param slack  how far xi may lie outside of the element, where X lies near a curved boundary.
  /// @return false if no element holds X; value then stays as it is.
  bool at(const Vec3& X, In<double> u, Vec3& value, double slack = 1e-9) const;

 private:
  double inside(int64_t element, const Vec3& X, double* N) const;

  const fem::ElementMesh& mesh_;
  Vec3 lower_ = {};
  double edge_ = 0;                            // of a bucket [m]
  int count_[3] = {};                          // buckets along each axis
  std::vector<std::vector<int32_t>> buckets_;  // elements whose box, a little larger, meets each
};

}  // namespace elastogen::test
