// SPDX-License-Identifier: Apache-2.0
// Metal: Hencky's elasticity, tau = k t 1 + 2 mu a n, that flows where |dev tau| reaches a radius
// which grows linearly with the flow. The map is radial, and consistent: the point ends on the
// surface as it is after the flow. It has a potential, the elastoplastic one of Li, Li, Jiang 2022
// (ECI), an instance of the variational updates of Ortiz and Stainier 1999.

#pragma once

#include "mpm_fem/materials/metal.hpp"
#include "mpm_fem/materials/yield.hpp"

namespace elastogen {

template <class T, int d = 3>
struct VonMises {
  using Real = T;
  using History = FlowHistory<T>;
  T mu, bulk;           ///< [Pa]
  T radius, hardening;  ///< |dev tau| <= radius + hardening flow [Pa]

  /// psi = k t^2/2 + mu s^2 + (radius + H flow) g + H g^2/2 with g = a - s the flow of the step:
  ///     g = (2 mu a - radius - H flow)/(2 mu + H) if positive, else 0.
  template <bool kTangent>
  ELASTOGEN_HD Returned<T> returned(const HenckyStrain<T, d>& e, const History& history) const {
    const T limit = radius + hardening * history.flow;
    const T excess = 2 * mu * e.size - limit;
    const T flow = excess > 0 ? excess / (2 * mu + hardening) : T(0), size = e.size - flow;
    Returned<T> r;
    for (int i = 0; i < d; ++i) r.e[i] = e.e[i];
    if (flow > 0) set_strain<d>(e.trace, size, e.n, r.e);
    r.psi = bulk / 2 * e.trace * e.trace + mu * size * size + (limit + hardening / 2 * flow) * flow;
    const T slope = flow > 0 ? 2 * mu * (hardening / (2 * mu + hardening)) : 2 * mu;
    const RadialStress<T> stress = {bulk * e.trace, bulk, 0, 2 * mu * size, 0, slope};
    set_stress<kTangent>(e, stress, r);
    return r;
  }

  template <bool kTangent>
  ELASTOGEN_HD Response<T> response(const T s[3], const History& history) const {
    return symmetric_in_stretches(s, returned<kTangent>(hencky_strain<d>(s), history));
  }

  ELASTOGEN_HD Returned<T> commit(const HenckyStrain<T, d>& e, History& history) const {
    return commit_flow(*this, e, history);
  }
  ELASTOGEN_HD void commit(T s[3], History& history) const {
    commit_stretches<d>(*this, s, history);
  }
};

/// @throws Error as check_yield.
template <class T, int d = 3>
VonMises<T, d> von_mises(const Material& material, const MetalYield& yield) {
  check_yield(material, yield);
  const double norm = yield_norm(d);
  return {T(material.mu()), T(bulk_modulus(material, d)), T(yield.stress / norm),
          T(yield.hardening / (norm * norm))};
}

}  // namespace elastogen
