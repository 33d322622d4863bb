// SPDX-License-Identifier: Apache-2.0
// Responses in principal stretches that are no gradient of an energy, as plastic laws have them:
// the derivative of the stress is not symmetric, and neither is dP/dF.

#pragma once

#include "core/principal.hpp"

namespace elastogen {

/// A response whose derivative D_ij = dt_i/ds_j need not be symmetric: a plastic law's.
template <class T>
struct NonsymmetricResponse {
  T psi;
  T t[3];
  Mat3<T> D;  ///< filled only if asked for
};

/// Response in stretches from that in e = ln s: tau = dpsi/de is Kirchhoff's stress, D_e = dtau/de,
///
///     t_i = tau_i/s_i,   dt_i/ds_j = (D_e,ij - delta_ij tau_i)/(s_i s_j),
///
/// and below s = 0.1, where e is law::continued_log, with its derivatives instead of 1/s and
/// -1/s^2.
template <class T>
ELASTOGEN_HD inline NonsymmetricResponse<T> from_log_strain(const T s[3], const T& psi,
                                                            const T tau[3], const Mat3<T>& D_e) {
  NonsymmetricResponse<T> r;
  T first[3], second[3];
  for (int i = 0; i < 3; ++i) {
    const law::Logarithm<T> l = law::continued_log(T(s[i] - 1));
    first[i] = l.first, second[i] = l.second;
  }
  r.psi = psi;
  for (int i = 0; i < 3; ++i) {
    r.t[i] = tau[i] * first[i];
    for (int j = 0; j < 3; ++j) r.D(i, j) = D_e(i, j) * first[i] * first[j];
    r.D(i, i) += tau[i] * second[i];
  }
  return r;
}

/// The derivative of P in the principal frame.
template <class T>
ELASTOGEN_HD inline PrincipalHessian<T, Mat3<T>> principal_hessian(
    const T s[3], const NonsymmetricResponse<T>& r) {
  PrincipalHessian<T, Mat3<T>> h;
  h.A = r.D;
  T limit[3];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    limit[i] = (r.D(i, i) + r.D(j, j) - r.D(i, j) - r.D(j, i)) / 2;
  }
  principal::fill_pairs(s, r.t, limit, h);
  return h;
}

/// The positive semi-definite Hessian nearest to the symmetric part.
template <class T>
ELASTOGEN_HD inline PrincipalHessian<T> positive_part(const PrincipalHessian<T, Mat3<T>>& h) {
  PrincipalHessian<T> symmetric;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    symmetric.A.m[i] = h.A(i, i);
    symmetric.A.m[3 + i] = (h.A(i, j) + h.A(j, i)) / 2;
    symmetric.twist[i] = h.twist[i];
    symmetric.flip[i] = h.flip[i];
  }
  return positive_part(symmetric);
}

}  // namespace elastogen
