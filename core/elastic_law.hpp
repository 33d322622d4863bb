// SPDX-License-Identifier: Apache-2.0
// Isotropic elastic laws in principal stretches: psi, its gradient t = dpsi/dsigma, its Hessian
// H = d2psi/dsigma2. At rest psi = 0, t = 0, H = 2 mu I + lambda 1 1^T for every law.
//
//   fixed corotated      mu sum (s-1)^2 + lambda/2 (J-1)^2
//   neo-Hookean          mu/2 (I-3) - mu l(J) + lambda/2 l(J)^2,   l = ln J, continued below 0.1
//   stable neo-Hookean   mu'/2 [I-3 - ln((I+1)/4)] + lambda'/2 [(J-a)^2 - (1-a)^2]  (Smith et al.
//                        2018), mu' = 4 mu/3, lambda' = lambda + 5 mu/6, a = 1 + 3 mu'/(4 lambda')
//   StVK                 mu sum e^2 + lambda/2 (sum e)^2,   e = (s^2-1)/2
//   Hencky               as StVK with e = ln s, continued below s = 0.1
//   Ogden                2 mu/a^2 sum (exp(a e'_i) - 1) + K/2 (sum e)^2,  a = shape; a = 0: Hencky
//   Mooney-Rivlin        mu/2 [(1 - r) (I1 - 3) + r (I2 - 3)] + K/2 (sum e)^2,  r = shape
//   Gent                 -mu L/2 ln(1 - (I1 - 3)/L) + K/2 (sum e)^2,  L = shape, the logarithm
//                        continued where I1 - 3 is above 0.9 L
//
// with I = sum s^2, J = s_0 s_1 s_2, K = lambda + 2 mu/3, and for the last three the e of Hencky,
// e'_i = e_i - sum e/3, I1 = sum exp(2 e'_i), I2 = sum exp(-2 e'_i): the invariants of C without
// its volume, J^(-2/3) I and J^(-4/3) times the second of C (Holzapfel, Nonlinear Solid
// Mechanics, 6.5). The continuation of ln is the C2 quadratic ln y0 + d - d^2/2, d = (y - y0)/y0,
// that of exp exp(x0) (1 + d + d^2/2), d = x - x0, above x0 = 12, so every law has a finite force
// in every state.
// Written in s - 1, so that no digits are lost near rest (docs/physics.md). A learned law has this
// interface too: a function from stretches to Response.

#pragma once

#include "core/material.hpp"
#include "core/pack_functions.hpp"

namespace elastogen {

/// Law and moduli [Pa] as kernels read them.
template <class S>
struct LawParameters {
  Law law = {};
  S mu = 0, lambda = 0;
};

/// Energy [J/m^3], gradient [Pa] and, if asked for, Hessian [Pa] in stretches.
template <class T>
struct Response {
  T psi;
  T t[3];
  T H[6];  ///< 00, 11, 22, 01, 12, 20; filled only if asked for
};

namespace law {

/// l(y) = ln y continued below y0, with first and second derivative; y is given as y - 1.
template <class T>
struct Logarithm {
  T value, first, second;
};

template <class T>
ELASTOGEN_HD inline Logarithm<T> continued_log(const T& y_minus_1) {
  using S = Scalar<T>;
  constexpr S kStart = S(0.1), kLogStart = S(-2.302585092994045684);
  const auto inside = y_minus_1 > kStart - 1;
  const T safe = inside ? y_minus_1 : constant<T>(kStart - 1);
  const T inverse = 1 / (1 + safe), d = (y_minus_1 - (kStart - 1)) / kStart;
  Logarithm<T> l;
  l.value = inside ? log_1p(safe) : kLogStart + d - d * d / 2;
  l.first = inside ? inverse : (1 - d) / kStart;
  l.second = inside ? -inverse * inverse : constant<T>(-1 / (kStart * kStart));
  return l;
}

/// Adds the terms with psi_J = dpsi/dJ and psi_JJ to the response of the part in s alone.
template <bool kHessian, class T>
ELASTOGEN_HD inline void add_volume_part(const T s[3], const T& psi_J, const T& psi_JJ,
                                         Response<T>& r) {
  const T minor[3] = {s[1] * s[2], s[2] * s[0], s[0] * s[1]};  // dJ/ds
  for (int i = 0; i < 3; ++i) r.t[i] += psi_J * minor[i];
  if constexpr (kHessian) {
    for (int i = 0; i < 3; ++i) r.H[i] += psi_JJ * minor[i] * minor[i];
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      r.H[3 + i] += psi_JJ * minor[i] * minor[j] + psi_J * s[k];
    }
  }
}

template <bool kHessian, class T>
ELASTOGEN_HD inline Response<T> fixed_corotated(const T e[3], const T s[3], const T& J_minus_1,
                                                Scalar<T> mu, Scalar<T> lambda) {
  Response<T> r;
  r.psi = mu * (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) + lambda / 2 * J_minus_1 * J_minus_1;
  for (int i = 0; i < 3; ++i) r.t[i] = 2 * mu * e[i];
  if constexpr (kHessian)
    for (int i = 0; i < 6; ++i) r.H[i] = constant<T>(i < 3 ? 2 * mu : 0);
  add_volume_part<kHessian>(s, T(lambda * J_minus_1), constant<T>(lambda), r);
  return r;
}

template <bool kHessian, class T>
ELASTOGEN_HD inline Response<T> neo_hookean(const T e[3], const T s[3], const T& J_minus_1,
                                            Scalar<T> mu, Scalar<T> lambda) {
  const Logarithm<T> l = continued_log(J_minus_1);
  // mu/2 (I - 3) - mu ln J with the linear terms, which cancel, left out where they are exact
  const T I_minus_3 = e[0] * (2 + e[0]) + e[1] * (2 + e[1]) + e[2] * (2 + e[2]);
  Response<T> r;
  r.psi = mu * (I_minus_3 / 2 - l.value) + lambda / 2 * l.value * l.value;
  // t_i = mu s_i + psi_J dJ/ds_i; in the regular range mu (s_i - 1/s_i) + lambda ln J / s_i
  const T psi_J = (lambda * l.value - mu) * l.first;
  const auto inside = J_minus_1 > Scalar<T>(0.1) - 1;
  const T minor[3] = {s[1] * s[2], s[2] * s[0], s[0] * s[1]};
  for (int i = 0; i < 3; ++i) {
    const T regular = (mu * e[i] * (2 + e[i]) + lambda * l.value) * minor[i] * l.first;
    r.t[i] = inside ? regular : mu * s[i] + psi_J * minor[i];
  }
  if constexpr (kHessian) {
    const T t[3] = {r.t[0], r.t[1], r.t[2]};
    for (int i = 0; i < 6; ++i) r.H[i] = constant<T>(i < 3 ? mu : 0);
    const T psi_JJ = (lambda * l.value - mu) * l.second + lambda * l.first * l.first;
    add_volume_part<true>(s, psi_J, psi_JJ, r);
    for (int i = 0; i < 3; ++i) r.t[i] = t[i];
  }
  return r;
}

template <bool kHessian, class T>
ELASTOGEN_HD inline Response<T> stable_neo_hookean(const T e[3], const T s[3], const T& J_minus_1,
                                                   Scalar<T> mu, Scalar<T> lambda) {
  using S = Scalar<T>;
  const S m = 4 * mu / 3, l = lambda + 5 * mu / 6, offset = 3 * m / (4 * l);  // a - 1
  const T I_minus_3 = e[0] * (2 + e[0]) + e[1] * (2 + e[1]) + e[2] * (2 + e[2]);
  const T inverse = 1 / (I_minus_3 + 4);  // 1 / (I + 1)
  const T shear = (I_minus_3 + 3) * inverse;
  Response<T> r;
  r.psi =
      m / 2 * (I_minus_3 - log_1p(T(I_minus_3 / 4))) + l / 2 * J_minus_1 * (J_minus_1 - 2 * offset);
  // m s_i I/(I+1) + l (J - a) J_i; the parts 3m/4 s_i and 3m/4 J_i cancel at rest
  const T minor[3] = {s[1] * s[2], s[2] * s[0], s[0] * s[1]};
  const T d[3] = {e[0] - (e[1] + e[2] + e[1] * e[2]), e[1] - (e[2] + e[0] + e[2] * e[0]),
                  e[2] - (e[0] + e[1] + e[0] * e[1])};  // s_i - J_i
  const T excess = I_minus_3 * inverse / 4;             // I/(I+1) - 3/4
  for (int i = 0; i < 3; ++i)
    r.t[i] = m * excess * s[i] + S(0.75) * m * d[i] + l * J_minus_1 * minor[i];
  if constexpr (kHessian) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      r.H[i] = m * shear + 2 * m * s[i] * s[i] * inverse * inverse + l * minor[i] * minor[i];
      r.H[3 + i] = 2 * m * s[i] * s[j] * inverse * inverse + l * minor[i] * minor[j] +
                   l * (J_minus_1 - offset) * s[k];
    }
  }
  return r;
}

/// mu sum e^2 + lambda/2 (sum e)^2 of strains e(s) with derivatives first and second.
template <bool kHessian, class T>
ELASTOGEN_HD inline Response<T> quadratic(const T e[3], const T first[3], const T second[3],
                                          Scalar<T> mu, Scalar<T> lambda) {
  const T trace = e[0] + e[1] + e[2];
  Response<T> r;
  r.psi = mu * (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) + lambda / 2 * trace * trace;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const T w = 2 * mu * e[i] + lambda * trace;
    r.t[i] = w * first[i];
    if constexpr (kHessian) {
      r.H[i] = (2 * mu + lambda) * first[i] * first[i] + w * second[i];
      r.H[3 + i] = lambda * first[i] * first[j];
    }
  }
  return r;
}

/// E(x) = exp(x) - 1 - x and its derivatives, accurate near x = 0; exp is continued above 12.
template <class T>
struct Exponential {
  T value, first, second;
};

template <class T>
ELASTOGEN_HD inline Exponential<T> continued_exp(const T& x) {
  using S = Scalar<T>;
  constexpr S kEnd = 12, kAtEnd = S(162754.79141900392);  // exp(12)
  const auto inside = x < kEnd;
  const T safe = inside ? x : constant<T>(kEnd), d = x - safe;
  // by its series where exp(x) - 1 - x loses digits
  constexpr int kTerms = sizeof(S) == 4 ? 10 : 17;
  T sum = constant<T>(1);
  for (int k = kTerms; k >= 3; --k) sum = 1 + safe / S(k) * sum;
  const auto small = absolute(safe) < 1;
  const T whole = exponential(safe);
  const T rest = small ? safe * safe / 2 * sum : whole - 1 - safe;
  Exponential<T> e;
  e.value = rest + d * (kAtEnd - 1 + kAtEnd / 2 * d);
  e.first = rest + safe + kAtEnd * d;
  e.second = inside ? whole : constant<T>(kAtEnd);
  return e;
}

/// Derivatives of an energy in log stretches.
template <class T>
struct LogDerivatives {
  T w[3], ww[6];  ///< 00, 11, 22, 01, 12, 20
};

/// Derivatives of f(e') + K/2 tr^2 from a_i = df/de'_i and b_i = d2f/de'_i^2, where f has no mixed
/// ones: w = P a + K tr, ww = P diag(b) P + K 1 1^T, P = I - 1 1^T/3.
template <class T>
ELASTOGEN_HD inline LogDerivatives<T> with_volume(const T a[3], const T b[3], const T& trace,
                                                  Scalar<T> bulk) {
  const T mean = (a[0] + a[1] + a[2]) / 3, sum = (b[0] + b[1] + b[2]) / 9;
  LogDerivatives<T> d;
  for (int i = 0; i < 3; ++i) {
    d.w[i] = a[i] - mean + bulk * trace;
    d.ww[i] = b[i] / 3 + sum + bulk;
    d.ww[3 + i] = bulk + sum - (b[i] + b[(i + 1) % 3]) / 3;
  }
  return d;
}

/// Adds (2 mu/power^2) sum E(power e'_i) and its derivatives a_i, b_i.
template <class T>
ELASTOGEN_HD inline void add_ogden(const T dev[3], Scalar<T> mu, Scalar<T> power, T& psi, T a[3],
                                   T b[3]) {
  for (int i = 0; i < 3; ++i) {
    const Exponential<T> e = continued_exp(T(power * dev[i]));
    psi += 2 * mu / power / power * e.value;
    a[i] += 2 * mu / power * e.first;
    b[i] += 2 * mu * e.second;
  }
}

template <class T>
ELASTOGEN_HD inline LogDerivatives<T> gent(const T dev[3], const T& trace, Scalar<T> mu,
                                           Scalar<T> bulk, Scalar<T> limit, T& psi) {
  using S = Scalar<T>;
  T excess{}, a[3] = {}, b[3] = {};  // I1 - 3
  add_ogden(dev, S(2), S(2), excess, a, b);
  const Logarithm<T> l = continued_log(T(-excess / limit));
  psi -= mu * limit / 2 * l.value;
  const T factor = mu / 2 * l.first, slope = -mu / (2 * limit) * l.second;
  const T mean = (a[0] + a[1] + a[2]) / 3, dI[3] = {a[0] - mean, a[1] - mean, a[2] - mean};
  for (int i = 0; i < 3; ++i) a[i] *= factor, b[i] *= factor;
  LogDerivatives<T> d = with_volume(a, b, trace, bulk);
  for (int i = 0; i < 3; ++i) {
    d.ww[i] += slope * dI[i] * dI[i];
    d.ww[3 + i] += slope * dI[i] * dI[(i + 1) % 3];
  }
  return d;
}

/// Ogden, Mooney-Rivlin and Gent from e = l(s), with the derivatives of l.
template <bool kHessian, class T>
ELASTOGEN_HD inline Response<T> deviatoric(const Law& law, const T e[3], const T first[3],
                                           const T second[3], Scalar<T> mu, Scalar<T> lambda) {
  using S = Scalar<T>;
  constexpr S kLeast = S(1e-6);  // of Ogden's exponent; nearer to 0 it is Hencky's law to the digit
  const S shape = S(law.shape), bulk = lambda + 2 * mu / 3;
  const T trace = e[0] + e[1] + e[2], third = trace / 3;
  const T dev[3] = {e[0] - third, e[1] - third, e[2] - third};
  Response<T> r;
  r.psi = bulk / 2 * trace * trace;
  // derivatives in log stretches
  LogDerivatives<T> d;
  if (law.kind == Law::Kind::kGent) {
    d = gent(dev, trace, mu, bulk, shape, r.psi);
  } else {
    T a[3] = {}, b[3] = {};
    if (law.kind == Law::Kind::kOgden) {
      add_ogden(dev, mu, shape < kLeast && shape > -kLeast ? kLeast : shape, r.psi, a, b);
    } else {
      add_ogden(dev, S(mu * (1 - shape)), S(2), r.psi, a, b);
      add_ogden(dev, S(mu * shape), S(-2), r.psi, a, b);
    }
    d = with_volume(a, b, trace, bulk);
  }
  // derivatives in stretches
  for (int i = 0; i < 3; ++i) {
    r.t[i] = d.w[i] * first[i];
    if constexpr (kHessian) {
      r.H[i] = d.ww[i] * first[i] * first[i] + d.w[i] * second[i];
      r.H[3 + i] = d.ww[3 + i] * first[i] * first[(i + 1) % 3];
    }
  }
  return r;
}

}  // namespace law

/// Response of a law to stretches of any sign.
/// @tparam kHessian  whether H is filled.
template <bool kHessian, class T>
ELASTOGEN_HD inline Response<T> elastic_response(const LawParameters<Scalar<T>>& p, const T s[3]) {
  // strains and J - 1, exact near rest
  const T e[3] = {s[0] - 1, s[1] - 1, s[2] - 1};
  const T pairs = e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
  const T J_minus_1 = e[0] + e[1] + e[2] + pairs + e[0] * e[1] * e[2];
  switch (p.law.kind) {
    case Law::Kind::kFixedCorotated:
      return law::fixed_corotated<kHessian>(e, s, J_minus_1, p.mu, p.lambda);
    case Law::Kind::kNeoHookean:
      return law::neo_hookean<kHessian>(e, s, J_minus_1, p.mu, p.lambda);
    case Law::Kind::kStableNeoHookean:
      return law::stable_neo_hookean<kHessian>(e, s, J_minus_1, p.mu, p.lambda);
    case Law::Kind::kStvk: {
      const T green[3] = {e[0] * (1 + e[0] / 2), e[1] * (1 + e[1] / 2), e[2] * (1 + e[2] / 2)};
      const T one[3] = {constant<T>(1), constant<T>(1), constant<T>(1)};
      return law::quadratic<kHessian>(green, s, one, p.mu, p.lambda);
    }
    default:
      break;
  }
  // the other laws are functions of log stretches
  T logs[3], first[3], second[3];
  for (int i = 0; i < 3; ++i) {
    const law::Logarithm<T> l = law::continued_log(e[i]);
    logs[i] = l.value, first[i] = l.first, second[i] = l.second;
  }
  if (p.law.kind == Law::Kind::kHencky)
    return law::quadratic<kHessian>(logs, first, second, p.mu, p.lambda);
  return law::deviatoric<kHessian>(p.law, logs, first, second, p.mu, p.lambda);
}

}  // namespace elastogen
