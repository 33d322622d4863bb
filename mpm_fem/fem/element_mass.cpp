// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"
#include "mpm_fem/fem/elastic_body.hpp"

#include <algorithm>

namespace elastogen::fem {

void ElasticBody::element_mass(int64_t element, double* M) const {
  const int nodes = nodes_of(mesh().element);
  double X[kMaxDofs], N[kMaxNodes], dN[kMaxDofs];
  element_nodes(mesh(), element, X);
  const double density = fill_of(mesh(), element) * material_of(element).density;
  std::fill(M, M + nodes * nodes, 0.0);
  for (const QuadraturePoint& point : mass_rule(mesh().element)) {
    Mat3<double> J;
    const Vec3 xi = in_part(mesh(), element, point.xi);
    shape_functions(mesh().element, xi, N);
    shape_gradients(mesh().element, xi, dN);
    jacobian(mesh().element, X, dN, J.m);
    const double weight = density * point.weight * determinant(J);
    for (int a = 0; a < nodes; ++a)
      for (int b = 0; b < nodes; ++b) M[nodes * a + b] += weight * N[a] * N[b];
  }
}

void ElasticBody::element_lumped_mass(int64_t element, double* m) const {
  const int nodes = nodes_of(mesh().element);
  if (is_voxel_mesh(mesh())) {
    const double mass =
        material_of(element).density * mesh().fill(element) * mesh().h * mesh().h * mesh().h;
    for (int a = 0; a < nodes; ++a) m[a] = mass * mesh().shape_mean(element, a);
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
  const int nodes = nodes_of(mesh().element);
  Array<double> corner(mesh().elements.size()), mass(mesh().rest.rows());
  for_each(mesh().elements.rows(),
           [&](int64_t e) { element_lumped_mass(e, corner.row(e * nodes)); });
  tables_.add_to_nodes(corner, mass);
  return mass;
}

Array<double> ElasticBody::volume() const {
  Array<double> volume(mesh().elements.rows());
  for (int64_t e = 0; e < volume.rows(); ++e) volume(e) = tables_.volume(e);
  return volume;
}

}  // namespace elastogen::fem
