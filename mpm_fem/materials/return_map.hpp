// SPDX-License-Identifier: Apache-2.0
// Shared by the return maps of isotropic plasticity. In the first d principal directions the Hencky
// strain e = ln s of the elastic trial splits into trace t and deviator a n, |n| = 1. From it a map
// gives the elastic strain after the step and Kirchhoff's stress tau with D = dtau/de. d = 3
// includes plane strain; with d = 2 stretch and stress out of the plane, the third, are left out.

#pragma once

#include "core/nonsymmetric_response.hpp"

#include <limits>

namespace elastogen {

/// e = (trace/d) 1 + size n; n = 0 if the deviator is 0.
template <class T, int d>
struct HenckyStrain {
  T e[3] = {}, n[3] = {}, trace = 0, size = 0;
};

/// The result of a map at a point. Energies are per unit of volume before any flow.
template <class T>
struct Returned {
  T e[3] = {};     ///< elastic Hencky strain
  T psi = 0;       ///< [J/m^3]
  T tau[3] = {};   ///< principal Kirchhoff stress [Pa]
  Mat3<T> D = {};  ///< dtau/de [Pa]; filled only if asked for
};

/// tau = mean 1 + shear n of laws that depend on trace and size alone, with both derivatives of
/// each.
template <class T>
struct RadialStress {
  T mean, mean_trace, mean_size, shear, shear_trace, shear_size;
};

template <int d, class T>
ELASTOGEN_HD inline HenckyStrain<T, d> split_strain(const T e[3]) {
  HenckyStrain<T, d> r;
  for (int i = 0; i < d; ++i) r.e[i] = e[i], r.trace += e[i];
  for (int i = 0; i < d; ++i) r.n[i] = e[i] - r.trace / d, r.size += r.n[i] * r.n[i];
  r.size = square_root(r.size);
  for (int i = 0; i < d; ++i) r.n[i] = r.size > 0 ? r.n[i] / r.size : T(0);
  return r;
}

/// Hencky strain of stretches s; below 0.1 the logarithm is continued as in the elastic laws.
template <int d, class T>
ELASTOGEN_HD inline HenckyStrain<T, d> hencky_strain(const T s[3]) {
  T e[3] = {};
  for (int i = 0; i < d; ++i) e[i] = law::continued_log(T(s[i] - 1)).value;
  return split_strain<d>(e);
}

/// Writes the stretches, numbers or packs, whose Hencky strains are `after`; stretches whose strain
/// does not change keep their bits.
template <int d, class T>
ELASTOGEN_HD inline void set_stretches(const T before[3], const T after[3], T s[3]) {
  constexpr auto kStart = Scalar<T>(0.1), kLogStart = Scalar<T>(-2.302585092994045684);
  for (int i = 0; i < d; ++i) {
    const auto moves = after[i] != before[i];
    if (!any(moves)) continue;
    const T below = after[i] - kLogStart;  // = x - x^2/2 in x = s/0.1 - 1
    const T continued = kStart * (2 - square_root(T(1 - 2 * smaller(below, constant<T>(0)))));
    const T stretch = below > 0 ? exponential(after[i]) : continued;
    s[i] = moves ? stretch : s[i];
  }
}

/// Ends the step of a law that has commit(strain, history), in stretches.
template <int d, class Law, class T>
ELASTOGEN_HD inline void commit_stretches(const Law& law, T s[3], typename Law::History& history) {
  const HenckyStrain<T, d> e = hencky_strain<d>(s);
  set_stretches<d>(e.e, law.commit(e, history).e, s);
}

/// The strain (trace/d) 1 + size n.
template <int d, class T>
ELASTOGEN_HD inline void set_strain(const T& trace, const T& size, const T n[3], T e[3]) {
  for (int i = 0; i < d; ++i) e[i] = trace / d + size * n[i];
}

/// tau and
/// D = mean_t 1 1^T + mean_a 1 n^T + shear_t n 1^T + shear_a n n^T + shear/a (I - 1 1^T/d - n n^T).
template <bool kTangent, int d, class T>
ELASTOGEN_HD inline void set_stress(const HenckyStrain<T, d>& e, const RadialStress<T>& r,
                                    Returned<T>& out) {
  for (int i = 0; i < d; ++i) out.tau[i] = r.mean + r.shear * e.n[i];
  if constexpr (kTangent) {
    const T secant = e.size > 0 ? r.shear / e.size : r.shear_size;
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < d; ++j) {
        const T nn = e.n[i] * e.n[j];
        out.D(i, j) = r.mean_trace + r.mean_size * e.n[j] + r.shear_trace * e.n[i] +
                      r.shear_size * nn + secant * ((i == j) - T(1) / d - nn);
      }
  }
}

/// The response in stretches.
template <class T>
ELASTOGEN_HD inline NonsymmetricResponse<T> in_stretches(const T s[3], const Returned<T>& r) {
  return from_log_strain(s, r.psi, r.tau, r.D);
}

/// in_stretches for a map that has a potential, psi.
template <class T>
ELASTOGEN_HD inline Response<T> symmetric_in_stretches(const T s[3], const Returned<T>& r) {
  const NonsymmetricResponse<T> full = in_stretches(s, r);
  Response<T> response;
  response.psi = full.psi;
  for (int i = 0; i < 3; ++i) {
    response.t[i] = full.t[i];
    response.H[i] = full.D(i, i);
    response.H[3 + i] = (full.D(i, (i + 1) % 3) + full.D((i + 1) % 3, i)) / 2;
  }
  return response;
}

template <class T>
struct ValueAndSlope {
  T value, slope;
};

/// The root of an increasing function that has one in [lower, upper]: Newton's steps from x, or the
/// middle of the bracket where a step leaves it.
/// @param f  f(x) gives ValueAndSlope
template <class T, class F>
ELASTOGEN_HD inline T increasing_root(const F& f, T lower, T upper, T x) {
  constexpr int kMost = 80;
  constexpr T kLast = 4 * std::numeric_limits<T>::epsilon();
  for (int k = 0; k < kMost; ++k) {
    const ValueAndSlope<T> r = f(x);
    if (r.value == 0) break;
    (r.value < 0 ? lower : upper) = x;
    T next = x - r.value / r.slope;
    if (!(next >= lower && next <= upper)) next = lower + (upper - lower) / 2;
    const bool is_last = absolute(T(next - x)) <= kLast * next;
    x = next;
    if (is_last) break;
  }
  return x;
}

}  // namespace elastogen
