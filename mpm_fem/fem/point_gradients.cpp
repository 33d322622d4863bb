// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/point_gradients.hpp"

#include <algorithm>

namespace elastogen::fem {

bool has_mean_dilatation(Element element) {
  return element == Element::kHexBbar || element == Element::kTet10Bbar;
}

PointGradients::PointGradients(Element element, const ElementState& e, double share)
    : shares_dilatation_(has_mean_dilatation(element)) {
  if (shares_dilatation_)
    mean_ = mean_dilatation(e, share);
  else
    for (int q = 0; q < e.points; ++q) mean_.Fbar[q] = deformation_gradient(e, q);
}

void PointGradients::add_force(const ElementState& e, Mat3<double>* P, double* f) const {
  if (shares_dilatation_) return add_mean_dilatation_gradient(e, mean_, P, f);
  for (int q = 0; q < e.points; ++q) {
    for (double& p : P[q].m) p *= e.weight[q];
    add_transposed(e, q, P[q], f);
  }
}

void PointGradients::stiffness(const ElementState& e, const Mat3<double>* P, double* A,
                               bool symmetric, double* K) const {
  if (shares_dilatation_) return mean_dilatation_hessian(e, mean_, P, A, symmetric, K);
  const int size = 3 * e.nodes;
  std::fill(K, K + size * size, 0.0);
  for (int q = 0; q < e.points; ++q) {
    for (int k = 81 * q; k < 81 * (q + 1); ++k) A[k] *= e.weight[q];
    symmetric ? add_product(e, q, A + 81 * q, K) : add_full_product(e, q, A + 81 * q, K);
  }
  if (symmetric) mirror(size, K);
}

}  // namespace elastogen::fem
