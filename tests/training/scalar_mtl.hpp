// SPDX-License-Identifier: Apache-2.0
// NeuralMTL of one net at one strain in double, by the formulas alone.

#pragma once

#include "core/base.hpp"

#include <cmath>
#include <vector>

namespace elastogen::test {

inline double silu(double z) {
  return z / (1 + std::exp(-z));
}

inline double silu_slope(double z) {
  const double s = 1 / (1 + std::exp(-z));
  return s + z * s * (1 - s);
}

/// f and its gradient at x.
struct NetValue {
  double f;
  Vec3 gradient;
};

/// @param w  W1 (128, 3), b1, W2 (128, 128), b2, w3, b3
inline NetValue net_value(const std::vector<float>& w, const Vec3& x) {
  const float *W1 = w.data(), *b1 = W1 + 384, *W2 = b1 + 128, *b2 = W2 + 16384, *w3 = b2 + 128;
  double z1[128], back[128] = {};
  for (int i = 0; i < 128; ++i)
    z1[i] = b1[i] + W1[3 * i] * x[0] + W1[3 * i + 1] * x[1] + W1[3 * i + 2] * x[2];
  NetValue value{w3[128], {}};
  for (int o = 0; o < 128; ++o) {
    double z2 = b2[o];
    for (int i = 0; i < 128; ++i) z2 += W2[128 * o + i] * silu(z1[i]);
    value.f += w3[o] * silu(z2);
    for (int i = 0; i < 128; ++i) back[i] += w3[o] * silu_slope(z2) * W2[128 * o + i];
  }
  for (int i = 0; i < 128; ++i)
    for (int m = 0; m < 3; ++m) value.gradient[m] += back[i] * silu_slope(z1[i]) * W1[3 * i + m];
  return value;
}

/// psi_theta over Young's modulus at stretches s.
inline double psi(const std::vector<float>& w, double poisson, const Vec3& s) {
  const double mu = 1 / (2 * (1 + poisson));
  const double lambda = poisson / ((1 + poisson) * (1 - 2 * poisson));
  const double omega = 3 * lambda + 2 * mu, a = std::sqrt(2 * mu / omega), b = (1 - a) / 3;
  const NetValue rest = net_value(w, {0, 0, 0});
  const Vec3 e = {std::log(s[0]), std::log(s[1]), std::log(s[2])};
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double ej = e[(i + 1) % 3], ek = e[(i + 2) % 3];
    const Vec3 x = {e[i], ej + ek, ej * ek};
    double q = (a + b) * e[i] + b * (ej + ek) + net_value(w, x).f - rest.f;
    for (int m = 0; m < 2; ++m) q -= rest.gradient[m] * x[m];
    sum += q * q;
  }
  return omega / 2 * sum;
}

/// d/dh of f(h) at 0, of fourth order.
template <class F>
double slope(const F& f, double h) {
  return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h);
}

/// dpsi/ds_i by differences.
inline double stress(const std::vector<float>& w, double poisson, Vec3 s, int i, double h = 1e-3) {
  return slope(
      [&](double d) {
        Vec3 at = s;
        at[i] += d;
        return psi(w, poisson, at);
      },
      h);
}

/// d2psi/ds_i ds_j by differences.
inline double tangent(const std::vector<float>& w, double poisson, Vec3 s, int i, int j) {
  constexpr double h = 4e-3;
  return slope(
      [&](double d) {
        Vec3 at = s;
        at[i] += d;
        return stress(w, poisson, at, j, h);
      },
      h);
}

}  // namespace elastogen::test
