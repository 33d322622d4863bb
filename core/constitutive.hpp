// SPDX-License-Identifier: Apache-2.0
// A law at a point, for every discretisation of the body: from the deformation gradient F and the
// history of the point to energy, stress and tangent. Laws are isotropic and given in principal
// stretches; core/principal.hpp brings them to F. Host and device, float, double and packs.

#pragma once

#include "core/nonsymmetric_response.hpp"
#include "core/tangent.hpp"

#include <type_traits>

namespace elastogen {

/// A law gives its response to stretches s from the history at the start of the step,
///
///     law.template response<kTangent>(s, history)   Response or NonsymmetricResponse of Real,
///
/// any number of times in a step. At the end of the step law.commit(s, history) is called once; it
/// sets stretches and history to those after the step, which are the elastic stretches of a plastic
/// law.
template <class L>
concept ConstitutiveLaw = requires(const L law, typename L::Real s[3],
                                   typename L::History history) {
  law.template response<true>(s, history).psi;
  law.template response<true>(s, history).t[0];
  law.commit(s, history);
};

struct NoHistory {};

/// The laws of core/elastic_law.hpp.
template <class T>
struct ElasticLaw {
  using Real = T;
  using History = NoHistory;
  LawParameters<Scalar<T>> parameters;

  template <bool kTangent>
  ELASTOGEN_HD Response<T> response(const T s[3], NoHistory) const {
    return elastic_response<kTangent>(parameters, s);
  }
  ELASTOGEN_HD void commit(T*, NoHistory&) const {}
};

/// psi(F) [J/m^3].
template <ConstitutiveLaw L>
ELASTOGEN_HD inline typename L::Real energy_density(const L& law, const Mat3<typename L::Real>& F,
                                                    const typename L::History& history = {}) {
  return law.template response<false>(svd3(F).sigma, history).psi;
}

/// First Piola stress P(F) [Pa], dpsi/dF where the law has a potential.
template <ConstitutiveLaw L>
ELASTOGEN_HD inline Mat3<typename L::Real> piola_stress(const L& law,
                                                        const Mat3<typename L::Real>& F,
                                                        const typename L::History& history = {}) {
  const Svd3<typename L::Real> s = svd3(F);
  return first_piola(s, law.template response<false>(s.sigma, history).t);
}

/// A principal Hessian as a matrix: A[9 k + l] = dP_k/dF_l over the row-major entries of F.
template <class T, class Block>
ELASTOGEN_HD inline void write_matrix(const PrincipalHessian<T, Block>& h, const Svd3<T>& F, T* A) {
  // column by column; a symmetric matrix is written row by row, which is contiguous
  constexpr bool kSymmetric = std::is_same_v<Block, Symmetric3<T>>;
  for (int l = 0; l < 9; ++l) {
    Mat3<T> unit{};
    unit.m[l] = constant<T>(1);
    const Mat3<T> dP = apply(h, F, unit);
    for (int k = 0; k < 9; ++k) A[kSymmetric ? 9 * l + k : 9 * k + l] = dP.m[k];
  }
}

/// dP/dF [Pa], row-major (9, 9) over the row-major entries of F.
/// @param kind  projected: the symmetric part, with its negative eigenvalues set to 0.
template <ConstitutiveLaw L>
ELASTOGEN_HD inline void piola_gradient(const L& law, const Mat3<typename L::Real>& F,
                                        TangentKind kind, typename L::Real A[81],
                                        const typename L::History& history = {}) {
  const Svd3<typename L::Real> s = svd3(F);
  const auto h = principal_hessian(s.sigma, law.template response<true>(s.sigma, history));
  if (kind == TangentKind::kProjected)
    write_matrix(positive_part(h), s, A);
  else
    write_matrix(h, s, A);
}

/// Ends the step: F becomes its elastic part, and the history that after the step.
template <ConstitutiveLaw L>
ELASTOGEN_HD inline void commit(const L& law, Mat3<typename L::Real>& F,
                                typename L::History& history) {
  if constexpr (std::is_empty_v<typename L::History>) return;  // nothing that could have changed F
  Svd3<typename L::Real> s = svd3(F);
  law.commit(s.sigma, history);
  F = first_piola(s, s.sigma);
}

}  // namespace elastogen
