// SPDX-License-Identifier: Apache-2.0
// Potentials for laws that have none: the variables that keep tau from being a gradient are frozen
// at a state, so that grad psi is the law's projected stress there (the idea of PlasticityNet, Li
// et al. 2022, whose potential is learned). A frozen potential is a law whose history is the frozen
// data; its commit changes nothing, since the step ends with the true law.

#pragma once

#include "core/eigen3.hpp"
#include "mpm_fem/materials/drucker_prager.hpp"

namespace elastogen {

/// mu a^2 up to the size where its slope is `limit`, then on with that slope. Returns the value.
template <class T>
ELASTOGEN_HD inline T capped_shear(T size, T mu, T limit, RadialStress<T>& stress) {
  const bool slides = 2 * mu * size > limit;
  stress.shear = slides ? limit : 2 * mu * size;
  stress.shear_size = slides ? T(0) : 2 * mu;
  return slides ? limit * (size - limit / (4 * mu)) : mu * size * size;
}

/// Sand with the radius of its cone and the opening frozen:
///     psi = k/2 min(t, 0)^2 + mu a^2, linear in a beyond radius/(2 mu)
/// with t the trace from the tip. Convex in e.
template <class T, int d = 3>
struct FrozenDruckerPrager {
  using Real = T;
  struct History {
    T radius = 0;   ///< |dev tau| [Pa]
    T opening = 0;  ///< as in DruckerPrager [-]
  };
  DruckerPrager<T, d> law;

  ELASTOGEN_HD History frozen(const T s[3],
                              const typename DruckerPrager<T, d>::History& history) const {
    const T t = law.trace(hencky_strain<d>(s), history);
    return {larger(T(-law.friction * t), T(0)), history.opening};
  }

  template <bool kTangent>
  ELASTOGEN_HD Returned<T> returned(const HenckyStrain<T, d>& e, const History& history) const {
    const T t = law.trace(e, {history.opening}), tip = d * law.cohesion, bulk = law.bulk;
    const T borne = smaller(t, T(0)) + tip, open = larger(t, T(0));
    RadialStress<T> stress = {bulk * borne, t < 0 ? bulk : T(0), 0, 0, 0, 0};
    Returned<T> r;
    r.psi = bulk / 2 * borne * borne + bulk * tip * open +
            capped_shear(e.size, law.mu, history.radius, stress);
    set_stress<kTangent>(e, stress, r);
    return r;
  }

  template <bool kTangent>
  ELASTOGEN_HD Response<T> response(const T s[3], const History& history) const {
    return symmetric_in_stretches(s, returned<kTangent>(hencky_strain<d>(s), history));
  }
  ELASTOGEN_HD void commit(T*, const History&) const {}
};

/// The quadratic potential of any law with a map:
///     psi = tau0.(e - e0) + (e - e0).S (e - e0)/2
/// with S the positive semi-definite part of the symmetric part of D at e0.
template <class Law, int d = 3>
struct FrozenQuadratic {
  using Real = typename Law::Real;
  struct History {
    Real e[3] = {}, tau[3] = {};
    Symmetric3<Real> S = {};
  };
  Law law;

  ELASTOGEN_HD History frozen(const Real s[3], const typename Law::History& history) const {
    const HenckyStrain<Real, d> e = hencky_strain<d>(s);
    const Returned<Real> r = law.template returned<true>(e, history);
    History h;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      h.e[i] = e.e[i], h.tau[i] = r.tau[i];
      h.S.m[i] = r.D(i, i), h.S.m[3 + i] = (r.D(i, j) + r.D(j, i)) / 2;
    }
    h.S = positive_part(h.S);
    return h;
  }

  template <bool kTangent>
  ELASTOGEN_HD Response<Real> response(const Real s[3], const History& history) const {
    const HenckyStrain<Real, d> e = hencky_strain<d>(s);
    Returned<Real> r;
    for (int i = 0; i < d; ++i) {
      r.tau[i] = history.tau[i];
      for (int j = 0; j < d; ++j) {
        r.D(i, j) = history.S(i, j);
        r.tau[i] += history.S(i, j) * (e.e[j] - history.e[j]);
      }
      r.psi += (history.tau[i] + r.tau[i]) / 2 * (e.e[i] - history.e[i]);
    }
    return symmetric_in_stretches(s, r);
  }
  ELASTOGEN_HD void commit(Real*, const History&) const {}
};

}  // namespace elastogen
