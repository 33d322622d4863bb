// SPDX-License-Identifier: Apache-2.0
// Sand: Hencky's elasticity with the cone |dev tau| <= -alpha tr tau of Drucker and Prager and flow
// that keeps the volume (Klar et al. 2016). Not associated: dtau/de is not symmetric. Without shear
// strength in tension a point opens; that opening is remembered and has to close before the point
// bears again (the volume correction of Tampubolon et al. 2017, here of the whole strain).

#pragma once

#include "mpm_fem/materials/return_map.hpp"
#include "mpm_fem/materials/yield.hpp"

namespace elastogen {

template <class T, int d = 3>
struct DruckerPrager {
  using Real = T;
  struct History {
    T opening = 0;  ///< trace of strain that opened and has not closed [-]
  };
  T mu, bulk;         ///< [Pa]
  T friction;         ///< alpha d k [Pa]: |dev tau| <= -friction (trace - its value at the tip)
  T cohesion;         ///< Hencky strain of the tip in every direction [-]
  bool keeps_volume;  ///< whether commit remembers the opening

  /// The trace from the tip, plus the opening that has to close; a point bears nothing above 0.
  ELASTOGEN_HD T trace(const HenckyStrain<T, d>& e, const History& history) const {
    return e.trace + history.opening - d * cohesion;
  }

  /// Moves a point to the tip or the cone, or leaves it inside; psi is its elastic energy then.
  template <bool kTangent>
  ELASTOGEN_HD Returned<T> returned(const HenckyStrain<T, d>& e, const History& history) const {
    const T t = trace(e, history), limit = -friction * t;
    const bool opens = t >= 0, slides = !opens && 2 * mu * e.size > limit;
    const T borne = (opens ? T(0) : t) + d * cohesion;
    const T shear = opens ? T(0) : slides ? limit : 2 * mu * e.size, size = shear / (2 * mu);
    Returned<T> r;
    if (opens || slides)
      set_strain<d>(borne, size, e.n, r.e);
    else
      for (int i = 0; i < d; ++i) r.e[i] = e.e[i] + history.opening / d;
    r.psi = bulk / 2 * borne * borne + mu * size * size;
    RadialStress<T> stress = {bulk * borne, bulk, 0, shear, 0, 2 * mu};
    if (opens) stress.mean_trace = stress.shear_size = 0;
    if (slides) stress.shear_trace = -friction, stress.shear_size = 0;
    set_stress<kTangent>(e, stress, r);
    return r;
  }

  template <bool kTangent>
  ELASTOGEN_HD NonsymmetricResponse<T> response(const T s[3], const History& history) const {
    return in_stretches(s, returned<kTangent>(hencky_strain<d>(s), history));
  }

  /// Ends a step: applies the map and stores the opening.
  ELASTOGEN_HD Returned<T> commit(const HenckyStrain<T, d>& e, History& history) const {
    const Returned<T> r = returned<false>(e, history);
    const T t = trace(e, history);
    history.opening = keeps_volume && t > 0 ? t : T(0);
    return r;
  }
  ELASTOGEN_HD void commit(T s[3], History& history) const {
    commit_stretches<d>(*this, s, history);
  }
};

/// alpha = sqrt(2/3) 2 sin/(3 - sin) of the friction angle: the cone through the triaxial
/// compression of Mohr and Coulomb. With d = 2 it is that of the angle with sine sqrt(2) alpha.
inline double cone_slope(double friction) {
  return std::sqrt(2.0 / 3) * 2 * std::sin(friction) / (3 - std::sin(friction));
}

/// @throws Error as check_yield.
template <class T, int d = 3>
DruckerPrager<T, d> drucker_prager(const Material& material, const SandYield& yield) {
  check_yield(material, yield);
  const double bulk = bulk_modulus(material, d);
  return {T(material.mu()), T(bulk), T(cone_slope(yield.friction) * d * bulk), T(yield.cohesion),
          yield.keeps_volume};
}

}  // namespace elastogen
