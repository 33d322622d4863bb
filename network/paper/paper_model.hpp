// SPDX-License-Identifier: Apache-2.0
// The local step of the published algorithm (ElastoGen, Eq. 4-7 and 10): stretches n_i of the
// target, fitted to the energy, and the lagged quadratic
//
//     E = omega/2 |F N - R|^2,   N = V diag(n) V^T,   R = U V^T,   omega = E,
//
// in which N and R are frozen while RNN-2 relaxes. Its stress omega (F N - R) N drops the
// derivative of N, so its stiffness is the geometric mean of omega and the true one: too small by
// sqrt(1 - 2 nu) in volume, too large by sqrt(1 + nu) in shear (docs/papers.md).

#pragma once

#include "core/pack_functions.hpp"
#include "core/svd3.hpp"
#include "network/potential/local_model.hpp"

namespace elastogen {

/// Frozen data of a voxel's lagged quadratic.
template <class T>
struct LaggedTarget {
  T NN[6];          ///< N N^T: 00, 11, 22, 01, 12, 20
  T rest[9];        ///< N N^T - R N^T, row-major: its stress at F = I, over omega
  T largest_slope;  ///< max n_i^2
};

/// omega, Young's modulus.
template <class S>
ELASTOGEN_HD inline S lagged_weight(const LawParameters<S>& law) {
  return law.mu * (3 * law.lambda + 2 * law.mu) / (law.lambda + law.mu);
}

/// n_i fitted to the energy of a law, or of its net: the strain q_i = sigma_i n_i - 1 has the
/// direction that is exact at rest and the length that gives the energy,
///
///     q0_i = (a + b) e_i + b (e_j + e_k),  e = ln sigma,   q = q0 sqrt(2 psi/omega)/|q0|,
///     a = sqrt(2 mu/omega),   b = (sqrt(3K/omega) - a)/3.
///
/// Stretches below 0.1 count as 0.1: n ~ 1/sigma would change its sign through collapse.
/// @param respond  the response of the material, as in local_model.hpp.
template <class T, class Respond>
ELASTOGEN_HD inline void fit_stretches(const Respond& respond, const LawParameters<Scalar<T>>& law,
                                       const T sigma[3], T n[3]) {
  using S = Scalar<T>;
  const S omega = lagged_weight(law);
  const S a = std::sqrt(2 * law.mu / omega);
  const S b = (std::sqrt((3 * law.lambda + 2 * law.mu) / omega) - a) / 3;
  T s[3], e[3], q[3], length2{};
  for (int i = 0; i < 3; ++i) {
    s[i] = larger(sigma[i], constant<T>(S(0.1)));
    e[i] = log_1p(T(s[i] - 1));
  }
  for (int i = 0; i < 3; ++i) {
    q[i] = a * e[i] + b * (e[0] + e[1] + e[2]);
    length2 += q[i] * q[i];
  }
  T outside;
  const T psi = larger(respond(s, outside).psi, T{});
  const T rest = constant<T>(S(1e-300));
  const T scale = length2 > rest ? square_root(T(2 * psi / (omega * larger(length2, rest)))) : T{};
  for (int i = 0; i < 3; ++i) n[i] = (1 + q[i] * scale) / s[i];
}

/// fit_stretches for a law, or its net.
template <class T>
inline void energy_fitted_stretches(const LearnedLaw* learned, const LawParameters<Scalar<T>>& law,
                                    const T sigma[3], T n[3]) {
  const auto respond = [&](const T s[3], T& outside) {
    return material_response<false>(learned, law, s, outside);
  };
  fit_stretches(respond, law, sigma, n);
}

/// The frozen quadratic of a voxel at F.
template <class T, class Respond>
ELASTOGEN_HD inline LaggedTarget<T> lagged_target(const Respond& respond,
                                                  const LawParameters<Scalar<T>>& law,
                                                  const Mat3<T>& F) {
  const Svd3<T> s = svd3(F);
  T n[3];
  fit_stretches(respond, law, s.sigma, n);
  LaggedTarget<T> target;
  target.largest_slope = T{};
  Mat3<T> Un, Vn;
  for (int j = 0; j < 3; ++j) {
    target.largest_slope = larger(target.largest_slope, T(n[j] * n[j]));
    for (int i = 0; i < 3; ++i) Un(i, j) = s.U(i, j) * n[j], Vn(i, j) = s.V(i, j) * n[j] * n[j];
  }
  const Mat3<T> RN = times_transposed(Un, s.V), NN = times_transposed(Vn, s.V);
  for (int k = 0; k < 9; ++k) target.rest[k] = NN.m[k] - RN.m[k];
  for (int k = 0; k < 3; ++k) {
    target.NN[k] = NN(k, k);
    target.NN[3 + k] = NN(k, (k + 1) % 3);
  }
  return target;
}

}  // namespace elastogen
