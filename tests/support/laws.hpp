// SPDX-License-Identifier: Apache-2.0
// The laws, three of the families, and their response as functions of F.

#pragma once

#include "core/principal.hpp"

namespace elastogen::test {

inline constexpr Law kLaws[] = {
    Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean,   Law::kStvk,   Law::kHencky,
    Law::ogden(5.5),      Law::ogden(-3),   Law::mooney_rivlin(0.25), Law::gent(12)};

/// Parameters from Young's modulus [Pa] and Poisson's ratio.
template <class S>
LawParameters<S> parameters(Law law, double young, double poisson) {
  Material m;
  m.young = young, m.poisson = poisson;
  return {law, S(m.mu()), S(m.lambda())};
}

/// Everything that a law says at F.
template <class T>
struct Point {
  Svd3<T> svd;
  Response<T> r;
  Mat3<T> P;
  PrincipalHessian<T> hessian;
};

template <class T>
Point<T> point(const LawParameters<Scalar<T>>& law, const Mat3<T>& F) {
  Point<T> result;
  result.svd = svd3(F);
  result.r = elastic_response<true>(law, result.svd.sigma);
  result.P = first_piola(result.svd, result.r.t);
  result.hessian = principal_hessian(result.svd.sigma, result.r);
  return result;
}

}  // namespace elastogen::test
