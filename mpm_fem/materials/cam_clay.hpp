// SPDX-License-Identifier: Apache-2.0
// Snow: decoupled neo-Hookean elasticity with the non-associated Cam-Clay of Gaume et al. 2018 and
// Wolper et al. 2019 (CD-MPM). With p = -k (J^2 - 1)/2 and dev tau = mu dev exp(2 a n)
//
//     y = (1 + 2 beta) q^2 + M^2 (p + beta p0)(p - p0) <= 0,   q^2 = (6-d)/2 |dev tau|^2.
//
// A point beyond a tip of the ellipse goes to the tip; between the tips shear is reduced to the
// ellipse. There the published map keeps tr b; this one keeps J, so that the point ends on the
// ellipse. p0 = k (1e-5 + sinh(-xi a)) with a = ln Jp < 0; a keeps its value during a step.

#pragma once

#include "mpm_fem/materials/return_map.hpp"
#include "mpm_fem/materials/yield.hpp"

namespace elastogen {

/// The elastic part, mu/2 (J^(-2/d) tr b - d) + k/2 ((J^2 - 1)/2 - ln J), without the second term.
template <class T>
struct SnowShear {
  T A[3] = {}, dev[3] = {}, size = 0, energy = 0;  ///< mu J^(-2/d) b, its deviator, |dev|
};

template <class T, int d>
ELASTOGEN_HD inline SnowShear<T> snow_shear(const HenckyStrain<T, d>& e, T mu) {
  SnowShear<T> r;
  T mean = 0;
  for (int i = 0; i < d; ++i) {
    r.dev[i] = mu * std::expm1(2 * e.size * e.n[i]);
    r.A[i] = mu + r.dev[i], mean += r.dev[i] / d;
  }
  for (int i = 0; i < d; ++i) r.dev[i] -= mean, r.size += r.dev[i] * r.dev[i];
  r.size = square_root(r.size);
  r.energy = mean * d / 2;
  return r;
}

/// k/2 ((J^2 - 1)/2 - ln J) [J/m^3] of trace t = ln J, and its slope -p [Pa].
template <class T>
ELASTOGEN_HD inline ValueAndSlope<T> snow_volume(T bulk, T t) {
  const T growth = std::expm1(2 * t);
  return {bulk / 2 * (growth / 2 - t), bulk / 2 * growth};
}

/// The yield ellipse of a step.
template <class T>
struct SnowEllipse {
  T pressure, tension;   ///< p0, beta p0 [Pa]
  T compressed, opened;  ///< traces ln J of the two tips
};

template <class T, int d = 3>
struct CamClay {
  using Real = T;
  struct History {
    T compaction = 0;  ///< change of a since the start [-]; negative where denser
  };
  T mu, bulk;                    ///< [Pa]
  T slope, cohesion, hardening;  ///< M, beta, xi
  T start;                       ///< a at the start

  ELASTOGEN_HD SnowEllipse<T> ellipse(const History& history) const {
    constexpr T kMost = T(0.43604956);  // asinh 0.45: ln J of the tip needs p0 < k/2
    const T dense = larger(T(-hardening * (start + history.compaction)), T(0));
    SnowEllipse<T> y;
    y.pressure = bulk * (T(1e-5) + std::sinh(smaller(dense, kMost)));
    y.tension = cohesion * y.pressure;
    y.compressed = std::log1p(-2 * y.pressure / bulk) / 2;
    y.opened = std::log1p(2 * y.tension / bulk) / 2;
    return y;
  }

  /// |dev tau| on the ellipse [Pa] and its slope in the trace.
  ELASTOGEN_HD ValueAndSlope<T> radius(const SnowEllipse<T>& y, T trace) const {
    const T mean = snow_volume(bulk, trace).slope;
    const T square = (mean + y.pressure) * (y.tension - mean);
    if (!(square > 0) || trace <= y.compressed || trace >= y.opened) return {0, 0};
    const T size = slope / square_root(T(6 - d) / 2 * (1 + 2 * cohesion)) * square_root(square);
    return {size, size / square * (y.tension - y.pressure - 2 * mean) / 2 * (bulk + 2 * mean)};
  }

  template <bool kTangent>
  ELASTOGEN_HD Returned<T> returned(const HenckyStrain<T, d>& e, const History& history) const;

  template <bool kTangent>
  ELASTOGEN_HD NonsymmetricResponse<T> response(const T s[3], const History& history) const {
    return in_stretches(s, returned<kTangent>(hencky_strain<d>(s), history));
  }

  /// Ends a step: applies the map and adds the hardening.
  ELASTOGEN_HD Returned<T> commit(const HenckyStrain<T, d>& e, History& history) const {
    const Returned<T> r = returned<false>(e, history);
    bool flows = false;
    for (int i = 0; i < d; ++i) flows |= r.e[i] != e.e[i];
    if (flows) history.compaction += compaction(e, history);
    return r;
  }
  ELASTOGEN_HD void commit(T s[3], History& history) const {
    commit_stretches<d>(*this, s, history);
  }

  /// The change of a in a step: at a tip that of ln J; between the tips ln J less its value at the
  /// point where the line from the ellipse's centre to (p, q) leaves the ellipse.
  ELASTOGEN_HD T compaction(const HenckyStrain<T, d>& e, const History& history) const;
};

}  // namespace elastogen

#include "mpm_fem/materials/cam_clay_map.hpp"
