// SPDX-License-Identifier: Apache-2.0
// SiLU of a jet, one neuron: the value, 3 first and 6 second derivatives (00 11 22 01 12 20) with
// respect to the inputs of the net, or the value and the first derivatives alone.
//
//   a = act(z),   a_m = act'(z) z_m,   a_mn = act''(z) z_m z_n + act'(z) z_mn
//   act(z) = z s,   s = 1 / (1 + exp(-z)),   s' = s (1 - s)

#pragma once

#include "core/pack_functions.hpp"

#include <cmath>
#include <cstring>

namespace elastogen::silu {

inline constexpr int kFirst = 4, kSecond = 10;  ///< channels without and with second derivatives

/// Second derivative k is with respect to inputs row_of(k) and column_of(k).
ELASTOGEN_HD constexpr int row_of(int k) {
  return k % 3;
}
ELASTOGEN_HD constexpr int column_of(int k) {
  return k < 3 ? k : (k - 2) % 3;
}

ELASTOGEN_HD inline float exponential(float x) {
  return std::exp(x);
}

#ifndef __CUDACC__
/// exp(x) within 2 ulp for x in [-87, 88], and constant beyond: x = k ln 2 + r with |r| <= ln 2 /
/// 2, and exp(r) by its series.
inline Pack<float> exponential(const Pack<float>& x) {
  using T = Pack<float>;
  const T lower = constant<T>(-87), upper = constant<T>(88);
  const T y = smaller(larger(x, lower), upper);
  constexpr float kMagic = 12582912;  // 1.5 2^23: adding it rounds to an integer
  const T k = (y * 1.44269504f + kMagic) - kMagic;
  const T r = y - k * 0.693359375f + k * 2.12194440e-4f;  // ln 2 in two parts
  T sum = constant<T>(1 / 5040.f);
  for (const float c : {1 / 720.f, 1 / 120.f, 1 / 24.f, 1 / 6.f, 0.5f}) sum = sum * r + c;
  sum = 1 + (r + r * r * sum);
  const PackMask<float> bits = (__builtin_convertvector(k, PackMask<float>) + 127) << 23;
  T scale;
  std::memcpy(&scale, &bits, sizeof scale);
  return sum * scale;
}
#endif

/// act and its first three derivatives.
template <class T>
struct Activation {
  T value, first, second, third;
};

template <class T>
ELASTOGEN_HD inline Activation<T> activation(const T& z) {
  const T s = 1 / (1 + exponential(T(-z)));
  const T slope = s * (1 - s), u = 1 - 2 * s;  // s' and s''/s'
  Activation<T> act;
  act.value = z * s;
  act.first = s + z * slope;
  act.second = slope * (2 + z * u);
  act.third = slope * (3 * u + z * (u * u - 2 * slope));
  return act;
}

template <int kChannels, class T>
ELASTOGEN_HD inline void forward(const T z[kChannels], T a[kChannels]) {
  const Activation<T> act = activation(z[0]);
  a[0] = act.value;
  for (int m = 1; m < kFirst; ++m) a[m] = act.first * z[m];
  for (int k = 0; k < kChannels - kFirst; ++k) {
    a[4 + k] = act.second * z[1 + row_of(k)] * z[1 + column_of(k)] + act.first * z[4 + k];
  }
}

/// Gradient dz of a scalar with respect to z, from its gradient g with respect to a.
template <int kChannels, class T>
ELASTOGEN_HD inline void backward(const T z[kChannels], const T g[kChannels], T dz[kChannels]) {
  const Activation<T> act = activation(z[0]);
  dz[0] = act.first * g[0];
  for (int m = 1; m < kFirst; ++m) {
    dz[0] += act.second * z[m] * g[m];
    dz[m] = act.first * g[m];
  }
  for (int k = 0; k < kChannels - kFirst; ++k) {
    const int m = 1 + row_of(k), n = 1 + column_of(k);
    dz[0] += (act.third * z[m] * z[n] + act.second * z[4 + k]) * g[4 + k];
    dz[m] += act.second * z[n] * g[4 + k];
    dz[n] += act.second * z[m] * g[4 + k];
    dz[4 + k] = act.first * g[4 + k];
  }
}

}  // namespace elastogen::silu
