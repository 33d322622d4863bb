// SPDX-License-Identifier: Apache-2.0
// The laws of elastic_law.hpp that need no stretches, as functions of Green's strain
// E = (H + H^T + H^T H)/2, H = F - I: psi and the second Piola stress S = dpsi/dE, with C = I + 2 E
// and l = ln J = ln(det C)/2,
//
//   StVK                 mu E:E + lambda/2 (tr E)^2            S = 2 mu E + lambda tr E I
//   neo-Hookean          mu (tr E - l) + lambda/2 l^2          S = mu (I - C^-1) + lambda l C^-1
//   stable neo-Hookean   as there with I - 3 = 2 tr E          S = m I/(I+1) I + l' (J-a) J C^-1
//
// (m, l' are mu', lambda' there). All terms are formed from E, so that terms that cancel near rest
// cancel to the digits of E. A tenth of the work of singular values.

#pragma once

#include "core/eigen3.hpp"
#include "core/elastic_law.hpp"

namespace elastogen {

/// Energy [J/m^3], first Piola stress [Pa] and det F of a law without its stretches.
template <class T>
struct StrainResponse {
  T psi, J;
  Mat3<T> P;
};

/// Whether a law has this form.
ELASTOGEN_HD inline bool is_law_of_strain(const Law& law) {
  return law.kind == Law::Kind::kStvk || law.kind == Law::Kind::kNeoHookean ||
         law.kind == Law::Kind::kStableNeoHookean;
}

namespace strain {

template <class T>
ELASTOGEN_HD inline Symmetric3<T> green(const Mat3<T>& H) {
  using S = Scalar<T>;
  Symmetric3<T> E;
  for (int k = 0; k < 6; ++k) {
    const int i = k % 3, j = k < 3 ? i : (i + 1) % 3;
    E.m[k] =
        (H(i, j) + H(j, i) + (H(0, i) * H(0, j) + H(1, i) * H(1, j) + H(2, i) * H(2, j))) * S(0.5);
  }
  return E;
}

/// The adjugate, det A times the inverse.
template <class T>
ELASTOGEN_HD inline Symmetric3<T> adjugate(const Symmetric3<T>& A) {
  const T* a = A.m;
  return {{a[1] * a[2] - a[4] * a[4], a[2] * a[0] - a[5] * a[5], a[0] * a[1] - a[3] * a[3],
           a[4] * a[5] - a[3] * a[2], a[5] * a[3] - a[4] * a[0], a[3] * a[4] - a[5] * a[1]}};
}

/// A B of two matrices that commute.
template <class T>
ELASTOGEN_HD inline Symmetric3<T> product(const Symmetric3<T>& A, const Symmetric3<T>& B) {
  Symmetric3<T> C;
  for (int k = 0; k < 6; ++k) {
    const int i = k % 3, j = k < 3 ? i : (i + 1) % 3;
    C.m[k] = A(i, 0) * B(0, j) + A(i, 1) * B(1, j) + A(i, 2) * B(2, j);
  }
  return C;
}

template <class T>
struct Strain {
  Symmetric3<T> E, inverse;  ///< inverse: C^-1
  T trace, x;                ///< tr E, det C - 1
};

template <class T>
ELASTOGEN_HD inline T energy_and_stress(const LawParameters<Scalar<T>>& p, const Strain<T>& s,
                                        Symmetric3<T>& stress) {
  using S = Scalar<T>;
  const S mu = p.mu, lambda = p.lambda;
  if (p.law.kind == Law::Kind::kStvk) {
    T square{};
    for (int k = 0; k < 6; ++k) {
      square += (k < 3 ? S(1) : S(2)) * s.E.m[k] * s.E.m[k];
      stress.m[k] = 2 * mu * s.E.m[k] + (k < 3 ? lambda * s.trace : T{});
    }
    return mu * square + lambda / 2 * s.trace * s.trace;
  }
  Symmetric3<T> change = product(s.inverse, s.E);  // I - C^-1 = 2 C^-1 E
  for (int k = 0; k < 6; ++k) change.m[k] = 2 * change.m[k];
  if (p.law.kind == Law::Kind::kNeoHookean) {
    const T l = log_1p(s.x) / 2;
    for (int k = 0; k < 6; ++k) stress.m[k] = mu * change.m[k] + lambda * l * s.inverse.m[k];
    return mu * (s.trace - l) + lambda / 2 * l * l;
  }
  // m excess I + 3/4 m (I - J C^-1) + l (J - 1) J C^-1, whose parts vanish at rest
  const S m = 4 * mu / 3, l = lambda + 5 * mu / 6;
  const T J_minus_1 = s.x / (1 + square_root(1 + s.x)), I_minus_3 = 2 * s.trace;
  const T excess = I_minus_3 / (4 * (I_minus_3 + 4));  // I/(I+1) - 3/4
  const T of_inverse = l * J_minus_1 * (1 + J_minus_1) - S(0.75) * m * J_minus_1;
  for (int k = 0; k < 6; ++k)
    stress.m[k] =
        S(0.75) * m * change.m[k] + of_inverse * s.inverse.m[k] + (k < 3 ? m * excess : T{});
  return m / 2 * (I_minus_3 - log_1p(T(I_minus_3 / 4))) + l / 2 * J_minus_1 * J_minus_1 -
         S(0.75) * m * J_minus_1;
}

}  // namespace strain

/// Response of a law of strain to F = I + H; false where a stretch is outside 0.4 ... 3, or det F
/// not positive: there the strain has lost digits, or the law is continued in its stretches.
/// @param add  add(E, psi, S) adds to energy and stress what the material has besides its law.
template <class T, class Add>
ELASTOGEN_HD inline bool strain_response(const LawParameters<Scalar<T>>& law, const Mat3<T>& H,
                                         const Add& add, StrainResponse<T>& r) {
  using S = Scalar<T>;
  constexpr S kMostSquares = 9, kMostInverseSquares = 6;  // sums of s^2 and of 1/s^2
  const Mat3<T> F = plus_identity(H);
  strain::Strain<T> s;
  s.E = strain::green(H);
  const T* E = s.E.m;
  s.trace = E[0] + E[1] + E[2];
  const Symmetric3<T> minors = strain::adjugate(s.E);
  const T pairs = minors.m[0] + minors.m[1] + minors.m[2];
  const T det = E[0] * minors.m[0] + E[3] * minors.m[3] + E[5] * minors.m[5];
  s.x = 2 * s.trace + 4 * pairs + 8 * det;
  Symmetric3<T> C;
  for (int k = 0; k < 6; ++k) C.m[k] = 2 * E[k] + (k < 3 ? S(1) : S(0));
  s.inverse = strain::adjugate(C);
  // outside the range of strains the caller needs stretches
  const T square = 1 + s.x, inverse_trace = s.inverse.m[0] + s.inverse.m[1] + s.inverse.m[2];
  r.J = determinant(F);
  const auto regular = (r.J > 0) & (square > 0) & (3 + 2 * s.trace < kMostSquares) &
                       (inverse_trace < kMostInverseSquares * square);
  if (any(decltype(r.J > 0)(!regular))) return false;
  const T inverse_square = 1 / square;
  for (int k = 0; k < 6; ++k) s.inverse.m[k] = s.inverse.m[k] * inverse_square;
  Symmetric3<T> stress;
  r.psi = strain::energy_and_stress(law, s, stress);
  add(s.E, r.psi, stress);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      r.P(i, j) = F(i, 0) * stress(0, j) + F(i, 1) * stress(1, j) + F(i, 2) * stress(2, j);
  return true;
}

/// strain_response of a law alone.
template <class T>
ELASTOGEN_HD inline bool strain_response(const LawParameters<Scalar<T>>& law, const Mat3<T>& H,
                                         StrainResponse<T>& r) {
  return strain_response(
      law, H, [](const Symmetric3<T>&, T&, Symmetric3<T>&) {}, r);
}

}  // namespace elastogen
