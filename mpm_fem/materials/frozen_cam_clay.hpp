// SPDX-License-Identifier: Apache-2.0
// The frozen potential (frozen_potential.hpp) of snow: p0 and the radius of the ellipse are frozen,
// for d = 3 also the direction n0 of the deviator, along which shear has the energy
// W0(a) = mu/2 sum (exp(2 a n0_i) - 1). With a linear term l for shear across n0,
//
//     psi = U(t) + phi(a) + l.(e - e0).
//
// U and phi are the elastic energies up to the tips and to slope kappa, and linear beyond. psi is
// convex in e.

#pragma once

#include "mpm_fem/materials/cam_clay_map.hpp"

namespace elastogen {

template <class T, int d = 3>
struct FrozenCamClay {
  using Real = T;
  struct History {
    T e[3] = {}, n[3] = {};        ///< e0, n0
    T across[3] = {};              ///< l [Pa]; 0 with d = 2
    T most = 0, slope = 0;         ///< size at which W0' is kappa, and kappa [Pa]
    T compressed = 0, opened = 0;  ///< traces of the tips
  };
  CamClay<T, d> law;

  /// W0', W0''.
  ELASTOGEN_HD ValueAndSlope<T> shear(const T n[3], T size) const {
    ValueAndSlope<T> r = {0, 0};
    for (int i = 0; i < d; ++i) {
      const T growth = law.mu * std::expm1(2 * size * n[i]);
      r.value += n[i] * growth, r.slope += 2 * n[i] * n[i] * (growth + law.mu);
    }
    return r;
  }

  ELASTOGEN_HD History frozen(const T s[3], const typename CamClay<T, d>::History& history) const {
    const HenckyStrain<T, d> e = hencky_strain<d>(s);
    const SnowEllipse<T> y = law.ellipse(history);
    const SnowShear<T> elastic = snow_shear(e, law.mu);
    const T radius = law.radius(y, e.trace).value;
    History h;
    h.compressed = y.compressed, h.opened = y.opened;
    T along = 1;  // cosine of the angle between n0 and dev tau
    if (elastic.size > 0) {
      along = 0;
      for (int i = 0; i < d; ++i) h.n[i] = e.n[i], along += e.n[i] * elastic.dev[i] / elastic.size;
    } else {
      h.n[0] = square_root(T(0.5)), h.n[d - 1] = -h.n[0];  // any direction
    }
    h.slope = radius * along;
    const auto excess = [&](T size) {
      const ValueAndSlope<T> w = shear(h.n, size);
      return ValueAndSlope<T>{w.value - h.slope, w.slope};
    };
    // some n_i is at least 1/sqrt 6, so W0'' >= mu/3
    h.most = increasing_root(excess, T(0), T(3 * h.slope / law.mu), T(h.slope / (2 * law.mu)));
    const T size = smaller(radius, elastic.size);
    for (int i = 0; i < d; ++i) {
      h.e[i] = e.e[i];
      if (d == 3 && elastic.size > 0)
        h.across[i] = size * (elastic.dev[i] / elastic.size - along * e.n[i]);
    }
    return h;
  }

  template <bool kTangent>
  ELASTOGEN_HD Returned<T> returned(const HenckyStrain<T, d>& e, const History& h) const {
    const T t = smaller(larger(e.trace, h.compressed), h.opened), size = smaller(e.size, h.most);
    const bool slides = e.size > h.most;
    const ValueAndSlope<T> volume = snow_volume(law.bulk, t), w = shear(h.n, size);
    RadialStress<T> stress = {volume.slope,
                              t == e.trace ? law.bulk + 2 * volume.slope : T(0),
                              0,
                              slides ? h.slope : w.value,
                              0,
                              slides ? T(0) : w.slope};
    Returned<T> r;
    set_stress<kTangent>(e, stress, r);
    r.psi = volume.value + volume.slope * (e.trace - t) + h.slope * (e.size - size);
    for (int i = 0; i < d; ++i) {
      r.psi += law.mu / 2 * std::expm1(2 * size * h.n[i]) + h.across[i] * (e.e[i] - h.e[i]);
      r.tau[i] += h.across[i];
    }
    return r;
  }

  template <bool kTangent>
  ELASTOGEN_HD Response<T> response(const T s[3], const History& history) const {
    return symmetric_in_stretches(s, returned<kTangent>(hencky_strain<d>(s), history));
  }
  ELASTOGEN_HD void commit(T*, const History&) const {}
};

}  // namespace elastogen
