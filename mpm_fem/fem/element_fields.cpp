// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"
#include "mpm_fem/fem/elastic_body.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

/// Adds weight P F^T/J, the stress that a law gives at F, to xx yy zz xy yz zx.
void add_cauchy(const ElasticLaw<double>& law, const Mat3<double>& F, double weight,
                double* sigma) {
  const Mat3<double> tau = times_transposed(piola_stress(law, F), F);
  const double scale = weight / determinant(F);
  for (int i = 0; i < 3; ++i) {
    sigma[i] += scale * tau(i, i);
    sigma[3 + i] += scale * tau(i, (i + 1) % 3);
  }
}

}  // namespace

Array<double> ElasticBody::deformation_gradient(In<double> u) const {
  tables_.check_nodal(u);
  Array<double> result(mesh().elements.rows(), 9);
  for_each(result.rows(), [&](int64_t k) {
    const ElementState e = tables_.state(k, u);
    double volume = 0;
    for (int q = 0; q < e.points; ++q) volume += e.weight[q];
    for (int q = 0; q < e.points; ++q) {
      const Mat3<double> F = fem::deformation_gradient(e, q);
      for (int i = 0; i < 9; ++i) result(k, i) += e.weight[q] / volume * F.m[i];
    }
  });
  return result;
}

Array<double> ElasticBody::cauchy_stress(In<double> u) const {
  tables_.check_nodal(u);
  Array<double> result(mesh().elements.rows(), 6);
  for_each(result.rows(), [&](int64_t k) {
    const ElementState e = tables_.state(k, u);
    const PointGradients points(mesh().element, e);
    const ElasticLaw<double> law = law_of(k);
    double volume = 0;
    for (int q = 0; q < e.points; ++q) volume += e.weight[q];
    for (int q = 0; q < e.points; ++q)
      add_cauchy(law, points.F(q), e.weight[q] / volume, result.row(k));
  });
  return result;
}

double ElasticBody::min_j(In<double> u) const {
  tables_.check_nodal(u);
  Array<double> smallest(mesh().elements.rows());
  for_each(smallest.rows(), [&](int64_t k) {
    const ElementState e = tables_.state(k, u);
    smallest(k) = determinant(fem::deformation_gradient(e, 0));
    for (int q = 1; q < e.points; ++q)
      smallest(k) = std::min(smallest(k), determinant(fem::deformation_gradient(e, q)));
  });
  return *std::min_element(smallest.data(), smallest.data() + smallest.size());
}

}  // namespace elastogen::fem
