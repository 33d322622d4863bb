// SPDX-License-Identifier: Apache-2.0
// From the response in principal stretches to F: first Piola stress and the Hessian d2psi/dF2,
// projected to positive semi-definite.
//
// With F = U diag(s) V^T and G = U^T dF V the Hessian acts block by block: the 3x3 block H on the
// diagonal of G, and for each pair (i, j) two scalars, twist (t_i + t_j)/(s_i + s_j) on the
// antisymmetric and flip (t_i - t_j)/(s_i - s_j) on the symmetric part. Projection clamps these
// nine eigenvalues one by one (Smith, de Goes, Kim 2019). Where t is no gradient H is dt/ds, not
// symmetric, and only the block on the diagonal differs.

#pragma once

#include "core/eigen3.hpp"
#include "core/elastic_law.hpp"
#include "core/svd3.hpp"

namespace elastogen {

/// P = U diag(t) V^T [Pa].
template <class T>
ELASTOGEN_HD inline Mat3<T> first_piola(const Svd3<T>& F, const T t[3]) {
  Mat3<T> Ut;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) Ut(i, j) = F.U(i, j) * t[j];
  return times_transposed(Ut, F.V);
}

/// The Hessian in the principal frame; twist and flip of the pairs 01, 12, 20.
/// @tparam Block  Symmetric3, or Mat3 of a derivative of P that need not be symmetric.
template <class T, class Block = Symmetric3<T>>
struct PrincipalHessian {
  Block A;
  T twist[3], flip[3];
};

namespace principal {

/// Fills twist and flip; where two stretches nearly agree the flip is its limit.
template <class T, class Block>
ELASTOGEN_HD inline void fill_pairs(const T s[3], const T t[3], const T limit[3],
                                    PrincipalHessian<T, Block>& h) {
  using S = Scalar<T>;
  constexpr S kNear = sizeof(S) == 4 ? S(1e-3) : S(1e-6), kSmallest = S(1e-6);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const T sum = s[i] + s[j], difference = s[i] - s[j];
    const auto apart = absolute(difference) > kNear * (absolute(s[i]) + absolute(s[j]));
    const T quotient = (t[i] - t[j]) / (apart ? difference : constant<T>(1));
    h.flip[i] = apart ? quotient : limit[i];
    // sum >= 0 but for rounding: stretches are sorted by size
    h.twist[i] = (t[i] + t[j]) / larger(sum, constant<T>(kSmallest));
  }
}

/// The diagonal of B from that of G: B_ii = sum_j A_ij G_jj.
template <class T>
ELASTOGEN_HD inline void apply_block(const Symmetric3<T>& A, const Mat3<T>& G, Mat3<T>& B) {
  B(0, 0) = A.m[0] * G(0, 0) + A.m[3] * G(1, 1) + A.m[5] * G(2, 2);
  B(1, 1) = A.m[3] * G(0, 0) + A.m[1] * G(1, 1) + A.m[4] * G(2, 2);
  B(2, 2) = A.m[5] * G(0, 0) + A.m[4] * G(1, 1) + A.m[2] * G(2, 2);
}
template <class T>
ELASTOGEN_HD inline void apply_block(const Mat3<T>& A, const Mat3<T>& G, Mat3<T>& B) {
  for (int i = 0; i < 3; ++i) B(i, i) = A(i, 0) * G(0, 0) + A(i, 1) * G(1, 1) + A(i, 2) * G(2, 2);
}

}  // namespace principal

/// The Hessian of a law; equal stretches have the flip H_ii - H_ij.
template <class T>
ELASTOGEN_HD inline PrincipalHessian<T> principal_hessian(const T s[3], const Response<T>& r) {
  PrincipalHessian<T> h;
  for (int k = 0; k < 6; ++k) h.A.m[k] = r.H[k];
  T limit[3];
  for (int i = 0; i < 3; ++i) limit[i] = (r.H[i] + r.H[(i + 1) % 3]) / 2 - r.H[3 + i];
  principal::fill_pairs(s, r.t, limit, h);
  return h;
}

/// The nearest positive semi-definite Hessian: nine eigenvalues clamped at 0.
template <class T>
ELASTOGEN_HD inline PrincipalHessian<T> positive_part(const PrincipalHessian<T>& h) {
  PrincipalHessian<T> result;
  result.A = positive_part(h.A);
  for (int i = 0; i < 3; ++i) {
    result.twist[i] = larger(h.twist[i], constant<T>(0));
    result.flip[i] = larger(h.flip[i], constant<T>(0));
  }
  return result;
}

/// dP = d2psi/dF2 : dF.
template <class T, class Block>
ELASTOGEN_HD inline Mat3<T> apply(const PrincipalHessian<T, Block>& h, const Svd3<T>& F,
                                  const Mat3<T>& dF) {
  using S = Scalar<T>;
  const Mat3<T> G = transposed_times(F.U, dF) * F.V;
  Mat3<T> B;
  principal::apply_block(h.A, G, B);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const T sum = (h.flip[i] + h.twist[i]) * S(0.5), difference = (h.flip[i] - h.twist[i]) * S(0.5);
    B(i, j) = sum * G(i, j) + difference * G(j, i);
    B(j, i) = sum * G(j, i) + difference * G(i, j);
  }
  return times_transposed(F.U * B, F.V);
}

}  // namespace elastogen
