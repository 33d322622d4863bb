// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/pointwise.hpp"

#include <algorithm>

namespace elastogen::fem {

double pointwise_energy(const ElementState& e) {
  double energy = 0;
  for (int q = 0; q < e.points; ++q)
    energy += e.weight[q] * energy_density(e.law, deformation_gradient(e, q));
  return energy;
}

void add_pointwise_gradient(const ElementState& e, double* f) {
  for (int q = 0; q < e.points; ++q) {
    Mat3<double> P = piola_stress(e.law, deformation_gradient(e, q));
    for (double& p : P.m) p *= e.weight[q];
    add_transposed(e, q, P, f);
  }
}

void pointwise_hessian(const ElementState& e, TangentKind kind, double* K) {
  const int size = 3 * e.nodes;
  std::fill(K, K + size * size, 0.0);
  for (int q = 0; q < e.points; ++q) {
    double A[81];
    piola_gradient(e.law, deformation_gradient(e, q), kind, A);
    for (double& a : A) a *= e.weight[q];
    add_product(e, q, A, K);
  }
  mirror(size, K);
}

}  // namespace elastogen::fem
