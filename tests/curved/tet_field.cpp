// SPDX-License-Identifier: Apache-2.0
#include "tests/curved/tet_field.hpp"

#include "core/mat3.hpp"
#include "mpm_fem/fem/shape_functions.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::test {
namespace {

using fem::Element;

Box box_of(const fem::ElementMesh& mesh, int64_t element) {
  Box box;
  for (int a = 0; a < 10; ++a) {
    const double* X = mesh.rest.row(mesh.elements(element, a));
    box.add({X[0], X[1], X[2]});
  }
  // curved edges may leave the box of the nodes
  for (size_t d = 0; d < 3; ++d) {
    const double margin = 0.1 * box.extent(int(d));
    box.lower[d] -= margin;
    box.upper[d] += margin;
  }
  return box;
}

}  // namespace

TetField::TetField(const fem::ElementMesh& mesh) : mesh_(mesh) {
  // the edge of a bucket is the mean edge of the elements' boxes
  Box whole;
  double sum = 0;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    const Box box = box_of(mesh, e);
    whole.add(box.lower);
    whole.add(box.upper);
    for (int d = 0; d < 3; ++d) sum += box.extent(d) / 3;
  }
  lower_ = whole.lower;
  edge_ = sum / double(mesh.elements.rows());
  for (int d = 0; d < 3; ++d) count_[d] = int(whole.extent(d) / edge_) + 1;
  buckets_.resize(size_t(count_[0]) * size_t(count_[1]) * size_t(count_[2]));
  // list each element in the buckets that its box touches
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    const Box box = box_of(mesh, e);
    int first[3], last[3];
    for (size_t d = 0; d < 3; ++d) {
      first[d] = int((box.lower[d] - lower_[d]) / edge_);
      last[d] = std::min(int((box.upper[d] - lower_[d]) / edge_), count_[d] - 1);
    }
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i)
          buckets_[size_t(i + count_[0] * (j + count_[1] * k))].push_back(int32_t(e));
  }
}

/// The smallest barycentric coordinate of X in an element, with the shape functions there; -1 where
/// Newton's method does not end.
double TetField::inside(int64_t element, const Vec3& X, double* N) const {
  double nodes[30], dN[30];
  fem::element_nodes(mesh_, element, nodes);
  // `nodes` are relative to the first one; the size is the largest component of a corner
  const double* origin = mesh_.rest.row(mesh_.elements(element, 0));
  double size = 0;
  for (int k = 3; k < 12; ++k) size = std::max(size, std::abs(nodes[k]));
  Vec3 xi = {0.25, 0.25, 0.25};
  // Newton's method for the local coordinates xi
  for (int iteration = 0; iteration < 20; ++iteration) {
    fem::shape_functions(Element::kTet10, xi, N);
    Mat3<double> J;
    fem::shape_gradients(Element::kTet10, xi, dN);
    fem::jacobian(Element::kTet10, nodes, dN, J.m);
    Vec3 rest;
    double distance = 0;
    for (size_t d = 0; d < 3; ++d) {
      rest[d] = X[d] - origin[d];
      for (size_t a = 0; a < 10; ++a) rest[d] -= N[a] * nodes[3 * a + d];
      distance = std::max(distance, std::abs(rest[d]));
    }
    if (distance <= 1e-13 * size) return std::min({xi[0], xi[1], xi[2], 1 - xi[0] - xi[1] - xi[2]});
    const double det = determinant(J);
    if (!(std::abs(det) > 0)) return -1;
    for (int k = 0; k < 3; ++k) {
      Mat3<double> column = J;  // Cramer's rule
      for (int d = 0; d < 3; ++d) column(d, k) = rest[size_t(d)];
      xi[size_t(k)] = std::clamp(xi[size_t(k)] + determinant(column) / det, -1.0, 2.0);
    }
  }
  return -1;
}

bool TetField::at(const Vec3& X, In<double> u, Vec3& value, double slack) const {
  int64_t place = 0, stride = 1;
  for (size_t d = 0; d < 3; ++d) {
    const double share = (X[d] - lower_[d]) / edge_;
    if (!(share >= 0) || share >= count_[d]) return false;
    place += stride * int(share);
    stride *= count_[d];
  }
  double deepest = -slack, best[10];
  int64_t holder = -1;
  for (const int32_t e : buckets_[size_t(place)]) {
    double N[10];
    const double depth = inside(e, X, N);
    if (depth < deepest) continue;
    deepest = depth, holder = e;
    std::copy(N, N + 10, best);
  }
  if (holder < 0) return false;
  value = {};
  for (int a = 0; a < 10; ++a)
    for (int d = 0; d < 3; ++d) value[size_t(d)] += best[a] * u(mesh_.elements(holder, a), d);
  return true;
}

}  // namespace elastogen::test
