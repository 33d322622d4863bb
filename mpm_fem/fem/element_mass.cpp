// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"
#include "mpm_fem/fem/elastic_body.hpp"

#include <algorithm>

namespace elastogen::fem {

void ElasticBody::element_mass(int64_t element, double* M) const {
  const int nodes = nodes_of(mesh_.element);
  double X[kMaxDofs], N[kMaxNodes], dN[kMaxDofs];
  element_nodes(mesh_, element, X);
  const double density = fill_of(mesh_, element) * material_of(element).density;
  std::fill(M, M + nodes * nodes, 0.0);
  for (const QuadraturePoint& point : mass_rule(mesh_.element)) {
    Mat3<double> J;
    shape_functions(mesh_.element, point.xi, N);
    shape_gradients(mesh_.element, point.xi, dN);
    jacobian(mesh_.element, X, dN, J.m);
    const double weight = density * point.weight * determinant(J);
    for (int a = 0; a < nodes; ++a)
      for (int b = 0; b < nodes; ++b) M[nodes * a + b] += weight * N[a] * N[b];
  }
}

void ElasticBody::element_lumped_mass(int64_t element, double* m) const {
  const int nodes = nodes_of(mesh_.element);
  if (is_voxel_mesh(mesh_)) {
    const double mass =
        material_of(element).density * mesh_.fill(element) * mesh_.h * mesh_.h * mesh_.h;
    for (int a = 0; a < nodes; ++a) m[a] = mass * mesh_.shape_mean(element, a);
    return;
  }
  double M[kMaxNodes * kMaxNodes], total = 0, trace = 0;
  element_mass(element, M);
  for (int a = 0; a < nodes; ++a) {
    m[a] = 0;
    for (int b = 0; b < nodes; ++b) m[a] += M[nodes * a + b];
    total += m[a], trace += M[nodes * a + a];
  }
  if (nodes != 10) return;
  for (int a = 0; a < nodes; ++a) m[a] = total / trace * M[nodes * a + a];
}

Array<double> ElasticBody::lumped_mass() const {
  const int nodes = nodes_of(mesh_.element);
  Array<double> corner(mesh_.elements.rows(), nodes), mass(mesh_.rest.rows());
  for_each(mesh_.elements.rows(), [&](int64_t e) { element_lumped_mass(e, corner.row(e)); });
  for_each(mesh_.rest.rows(), [&](int64_t n) {
    for (int64_t k = first_corner_[size_t(n)]; k < first_corner_[size_t(n) + 1]; ++k)
      mass(n) += corner.data()[corner_[size_t(k)]];
  });
  return mass;
}

Array<double> ElasticBody::volume() const {
  Array<double> volume(mesh_.elements.rows());
  for (int64_t e = 0; e < volume.rows(); ++e) {
    for (int q = 0; q < weight_.cols(); ++q) volume(e) += weight_(shape_of(e), q);
    volume(e) *= fill_of(mesh_, e);
  }
  return volume;
}

}  // namespace elastogen::fem
