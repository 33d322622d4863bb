// SPDX-License-Identifier: Apache-2.0
// Damping by a solid's loss factor eta = tan(delta) at a frequency f (Kelvin and Voigt): beside its
// elastic stress a solid bears one that the rate of Green's strain E = (F^T F - I)/2 brings about,
//
//     S_v = tau (2 mu E' + lambda tr(E') I),     tau = eta / (2 pi f),
//
// so that at small strain every vibration has the loss factor eta (frequency / f). E does not change
// where a body turns: spin and flight lose nothing. In a stage of a time scheme E' = (E - E_b) / k,
// E_b known (core/time_stage.hpp), and S_v is the derivative in E of
//
//     D = beta (mu |E - E_b|^2 + lambda/2 tr(E - E_b)^2),     beta = tau / k,
//
// a part of the incremental potential; the power that is lost is 2 D / k. Shared by host and device.

#pragma once

#include "core/material.hpp"
#include "core/strain_law.hpp"
#include "core/tangent.hpp"

#include <numbers>

namespace elastogen {

/// tau of a material [s].
inline double viscous_time(const Material& m) {
  return m.loss_factor.value_or(0) / (2 * std::numbers::pi * m.loss_frequency);
}

/// beta times the Lame constants of a material [Pa]; 0: there is no damping.
template <class S>
struct ViscousModuli {
  S mu = 0, lambda = 0;
};

namespace viscous {

/// 2 mu A + lambda tr(A) I.
template <class T>
ELASTOGEN_HD inline Symmetric3<T> stress(const ViscousModuli<Scalar<T>>& v,
                                         const Symmetric3<T>& A) {
  const T pressure = v.lambda * (A.m[0] + A.m[1] + A.m[2]);
  Symmetric3<T> S;
  for (int k = 0; k < 6; ++k) S.m[k] = 2 * v.mu * A.m[k] + (k < 3 ? pressure : T{});
  return S;
}

/// Symmetric part of A^T B.
template <class T>
ELASTOGEN_HD inline Symmetric3<T> symmetric_product(const Mat3<T>& A, const Mat3<T>& B) {
  Symmetric3<T> result;
  for (int k = 0; k < 6; ++k) {
    const int i = k % 3, j = k < 3 ? i : (i + 1) % 3;
    T sum{};
    for (int l = 0; l < 3; ++l) sum += A(l, i) * B(l, j) + A(l, j) * B(l, i);
    result.m[k] = sum * Scalar<T>(0.5);
  }
  return result;
}

template <class T>
ELASTOGEN_HD inline void add_product(const Mat3<T>& F, const Symmetric3<T>& S, Mat3<T>& P) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      P(i, j) += F(i, 0) * S(0, j) + F(i, 1) * S(1, j) + F(i, 2) * S(2, j);
}

/// E - E_b at F = I + H.
template <class T>
ELASTOGEN_HD inline Symmetric3<T> change_of_strain(const Mat3<T>& H, const T E_b[6]) {
  Symmetric3<T> change = strain::green(H);
  for (int k = 0; k < 6; ++k) change.m[k] -= E_b[k];
  return change;
}

}  // namespace viscous

/// D [J/m^3] at F = I + H; adds its derivative F S_v to P [Pa].
/// @param E_b  00, 11, 22, 01, 12, 20.
template <class T>
ELASTOGEN_HD inline T add_viscous(const ViscousModuli<Scalar<T>>& v, const Mat3<T>& H,
                                  const T E_b[6], Mat3<T>& P) {
  const Symmetric3<T> change = viscous::change_of_strain(H, E_b);
  const Symmetric3<T> S = viscous::stress(v, change);
  viscous::add_product(plus_identity(H), S, P);
  T twice{};
  for (int k = 0; k < 6; ++k) twice += (k < 3 ? Scalar<T>(1) : Scalar<T>(2)) * S.m[k] * change.m[k];
  return twice * Scalar<T>(0.5);
}

/// Adds the change of F S_v along dF to dP. The projected tangent, which is to be positive, leaves
/// out dF S_v: that is the smaller, the less a step changes E.
template <class T>
ELASTOGEN_HD inline void add_viscous_tangent(const ViscousModuli<Scalar<T>>& v, const Mat3<T>& H,
                                             const T E_b[6], TangentKind kind, const Mat3<T>& dF,
                                             Mat3<T>& dP) {
  const Mat3<T> F = plus_identity(H);
  viscous::add_product(F, viscous::stress(v, viscous::symmetric_product(F, dF)), dP);
  if (kind == TangentKind::kProjected) return;
  viscous::add_product(dF, viscous::stress(v, viscous::change_of_strain(H, E_b)), dP);
}

}  // namespace elastogen
