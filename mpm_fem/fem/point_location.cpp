// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/point_location.hpp"

#include "core/error.hpp"
#include "core/mat3.hpp"

#include <algorithm>
#include <array>

namespace elastogen::fem {
namespace {

using Barycentric = std::array<double, 4>;

/// Barycentric coordinates: the volumes opposite to the corners over the whole volume.
Barycentric barycentric(const ElementMesh& mesh, int64_t element, const double* point) {
  const double* corner[4];
  for (int a = 0; a < 4; ++a) corner[a] = mesh.rest.row(mesh.elements(element, a));
  const auto volume = [](const double* a, const double* b, const double* c, const double* d) {
    Mat3<double> E;
    for (int i = 0; i < 3; ++i) E(i, 0) = b[i] - a[i], E(i, 1) = c[i] - a[i], E(i, 2) = d[i] - a[i];
    return determinant(E);
  };
  const double whole = volume(corner[0], corner[1], corner[2], corner[3]);
  Barycentric result;
  for (int a = 0; a < 4; ++a) {
    const double* x[4] = {corner[0], corner[1], corner[2], corner[3]};
    x[a] = point;
    result[size_t(a)] = volume(x[0], x[1], x[2], x[3]) / whole;
  }
  return result;
}

void shape_functions(const Barycentric& l, int nodes, double* N) {
  constexpr size_t kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (size_t a = 0; a < 4; ++a) N[a] = nodes == 4 ? l[a] : l[a] * (2 * l[a] - 1);
  for (size_t k = 0; k < 6 && nodes == 10; ++k) N[4 + k] = 4 * l[kEdges[k][0]] * l[kEdges[k][1]];
}

}  // namespace

int64_t locate(const ElementMesh& mesh, int64_t begin, int64_t end, const double* point,
               double* weights) {
  const int nodes = nodes_of(mesh.element);
  ELASTOGEN_CHECK(nodes != 8, "only tetrahedra can be searched for a point");
  ELASTOGEN_CHECK(0 <= begin && begin < end && end <= mesh.elements.rows(), "elements ", begin,
                  " ... ", end, " of ", mesh.elements.rows());
  int64_t best = begin;
  double depth = -1e300;
  for (int64_t e = begin; e < end; ++e) {
    const Barycentric l = barycentric(mesh, e, point);
    const double least = *std::min_element(l.begin(), l.end());
    if (!(least > depth)) continue;
    best = e, depth = least;
    shape_functions(l, nodes, weights);
  }
  return best;
}

}  // namespace elastogen::fem
