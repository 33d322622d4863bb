// SPDX-License-Identifier: Apache-2.0
// A quadrature point of a solid that flows, in space or in the plane. F is measured from the body
// at rest; the law's stretches are those of Fe = F Fp^-1, without the flow so far (Lee 1969):
//
//     P = P_e Fp^-T,   dP_ij/dF_kl = sum_ab (dP_e,ia/dFe_kb) Fp^-1_ja Fp^-1_lb.

#pragma once

#include "core/svd2.hpp"
#include "mpm_fem/materials/dissipation.hpp"

namespace elastogen::fem {

/// The point has its history from the start of the step.
template <ConstitutiveLaw L>
struct PlasticPoint {
  const L& law;
  typename L::History history;
  Mat3<double> Fp_inverse;

  /// Fe = U S V^T.
  Svd3<double> elastic(const Mat3<double>& F) const {
    return decompose<dimension<L>>(F * Fp_inverse);
  }
  /// psi [J/m^3].
  double energy(const Mat3<double>& F) const {
    return law.template response<false>(elastic(F).sigma, history).psi;
  }
  /// P [Pa].
  Mat3<double> stress(const Mat3<double>& F) const {
    const Svd3<double> Fe = elastic(F);
    const auto response = law.template response<false>(Fe.sigma, history);
    return times_transposed(first_piola(Fe, response.t), Fp_inverse);
  }
  /// dP/dF [Pa], (9, 9).
  void tangent(const Mat3<double>& F, TangentKind kind, double* A) const;

  StepWork work(const Mat3<double>& F) const { return step_work(law, elastic(F).sigma, history); }
  /// Ends the step at F: Fp^-1 and history become those after it.
  void commit(const Mat3<double>& F);
};

template <ConstitutiveLaw L>
void PlasticPoint<L>::tangent(const Mat3<double>& F, TangentKind kind, double* A) const {
  double of_elastic[81];
  const Svd3<double> Fe = elastic(F);
  const auto h = principal_hessian(Fe.sigma, law.template response<true>(Fe.sigma, history));
  if (kind == TangentKind::kProjected)
    write_matrix(positive_part(h), Fe, of_elastic);
  else
    write_matrix(h, Fe, of_elastic);
  // rows and columns of each 3x3 block (ia, kb) times Fp^-1 from both sides
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      Mat3<double> block;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) block(a, b) = of_elastic[9 * (3 * i + a) + 3 * k + b];
      block = times_transposed(Fp_inverse * block, Fp_inverse);
      for (int j = 0; j < 3; ++j)
        for (int l = 0; l < 3; ++l) A[9 * (3 * i + j) + 3 * k + l] = block(j, l);
    }
}

/// With Fe = U S V^T and S' the stretches after the step Fp'^-1 = Fp^-1 V (S'/S) V^T.
template <ConstitutiveLaw L>
void PlasticPoint<L>::commit(const Mat3<double>& F) {
  const Svd3<double> Fe = elastic(F);
  double s[3] = {Fe.sigma[0], Fe.sigma[1], Fe.sigma[2]};
  law.commit(s, history);
  if (s[0] == Fe.sigma[0] && s[1] == Fe.sigma[1] && s[2] == Fe.sigma[2]) return;
  Mat3<double> scaled;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) scaled(i, j) = Fe.V(i, j) * (s[j] / Fe.sigma[j]);
  Fp_inverse = Fp_inverse * times_transposed(scaled, Fe.V);
}

}  // namespace elastogen::fem
