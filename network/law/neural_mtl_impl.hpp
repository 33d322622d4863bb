// SPDX-License-Identifier: Apache-2.0
// The formulas of psi_theta (neural_mtl.hpp) for host and device: jets through the activation and a
// unit of the first layer, and the energy and its derivatives from f and those of f.

#pragma once

#include "core/base.hpp"

#include <cmath>

namespace elastogen {

/// Energy density and its derivatives in the log stretches e, over E.
struct LogJet {
  double psi = 0;
  double w[3] = {};   ///< dpsi/de_i, the principal Kirchhoff stress
  double ww[6] = {};  ///< d2psi/de_i de_j: 00, 11, 22, 01, 12, 20
};

/// The constants of psi_theta besides the weights.
struct MtlTerms {
  double omega = 0, a = 0, b = 0;
  double f0[3] = {};  ///< f, f_0 and f_1 at rest

  MtlTerms() = default;
  /// @param mu, lambda  over E.
  MtlTerms(double mu, double lambda)
      : omega(3 * lambda + 2 * mu), a(std::sqrt(2 * mu / omega)), b((1 - a) / 3) {}
};

namespace mtl {

/// Row and column of the entry c of 00, 11, 22, 01, 12, 20.
ELASTOGEN_HD constexpr int entry_row(int c) {
  return c % 3;
}
ELASTOGEN_HD constexpr int entry_column(int c) {
  return c < 3 ? c : (c + 1) % 3;
}

/// SiLU and its first two derivatives; A is a number or an array of them.
template <class A>
struct Silu {
  A value, first, second;
};

/// SiLU at z, with s = 1/(1 + exp(-z)).
template <class A>
ELASTOGEN_HD inline Silu<A> silu(const A& z, const A& s) {
  const A slope = s * (1 - s);
  return {z * s, s + z * slope, slope * (2 + z * (1 - 2 * s))};
}

/// Jets through the activation: a = act(z), a_m = act' z_m, a_mn = act'' z_m z_n + act' z_mn.
/// Channels are z, z_m and z_mn: 1, 4 or 10 of them.
template <int kChannels, class A, class Channel>
ELASTOGEN_HD inline void activate(const Silu<A>& act, const Channel& channel) {
  if constexpr (kChannels == 10)
    for (int c = 0; c < 6; ++c)
      channel(4 + c) = act.second * channel(1 + entry_row(c)) * channel(1 + entry_column(c)) +
                       act.first * channel(4 + c);
  if constexpr (kChannels >= 4)
    for (int m = 0; m < 3; ++m) channel(1 + m) *= act.first;
  channel(0) = act.value;
}

/// Jet of one number through the activation.
template <int kChannels>
ELASTOGEN_HD inline void activate(double z[kChannels]) {
  const double s = 1 / (1 + std::exp(-z[0]));
  activate<kChannels>(silu(z[0], s), [z](int c) -> double& { return z[c]; });
}

/// A unit of the first layer, activated, of weights w and bias b at the inputs x.
template <int kChannels>
ELASTOGEN_HD inline void first_unit(const float w[3], float b, const double x[3],
                                    double z[kChannels]) {
  z[0] = double(b);
  for (int m = 0; m < 3; ++m) {
    z[0] += double(w[m]) * x[m];
    if constexpr (kChannels >= 4) z[1 + m] = double(w[m]);
  }
  if constexpr (kChannels == 10)
    for (int c = 0; c < 6; ++c) z[4 + c] = 0;
  activate<kChannels>(z);
}

/// x_i of an axis.
ELASTOGEN_HD inline void inputs(const double e[3], int i, double x[3]) {
  const double ej = e[(i + 1) % 3], ek = e[(i + 2) % 3];
  x[0] = e[i], x[1] = ej + ek, x[2] = ej * ek;
}

/// q_i with its derivatives in e.
struct Strain {
  double q, d[3], dd[6];
};

/// The strain from f and its derivatives in x_i, with the terms at rest subtracted.
template <bool kHessian>
ELASTOGEN_HD inline Strain strain(const double e[3], int i, const double f[10],
                                  const MtlTerms& terms) {
  const double a = terms.a, b = terms.b, *f0 = terms.f0;
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const double fa = f[1] - f0[1] + a + b, fb = f[2] - f0[2] + b, fc = f[3];
  Strain s;
  s.q = (a + b) * e[i] + b * (e[j] + e[k]) + f[0] - f0[0] - f0[1] * e[i] - f0[2] * (e[j] + e[k]);
  s.d[i] = fa;
  s.d[j] = fb + e[k] * fc;
  s.d[k] = fb + e[j] * fc;
  if constexpr (kHessian) {
    // pair (m, n) is at 3 + m where n = m + 1
    const double aa = f[4], bb = f[5], cc = f[6], ab = f[7], bc = f[8], ca = f[9];
    s.dd[i] = aa;
    s.dd[j] = bb + 2 * e[k] * bc + e[k] * e[k] * cc;
    s.dd[k] = bb + 2 * e[j] * bc + e[j] * e[j] * cc;
    s.dd[3 + i] = ab + e[k] * ca;  // i, j
    s.dd[3 + k] = ab + e[j] * ca;  // k, i
    s.dd[3 + j] = fc + bb + (e[j] + e[k]) * bc + e[j] * e[k] * cc;
  }
  return s;
}

/// psi = omega/2 sum q^2 and its derivatives.
template <bool kHessian>
ELASTOGEN_HD inline LogJet energy(const Strain s[3], double omega) {
  LogJet r;
  for (int i = 0; i < 3; ++i) {
    r.psi += omega / 2 * s[i].q * s[i].q;
    for (int m = 0; m < 3; ++m) r.w[m] += omega * s[i].q * s[i].d[m];
    if constexpr (kHessian)
      for (int c = 0; c < 6; ++c)
        r.ww[c] += omega * (s[i].d[entry_row(c)] * s[i].d[entry_column(c)] + s[i].q * s[i].dd[c]);
  }
  return r;
}

}  // namespace mtl
}  // namespace elastogen
