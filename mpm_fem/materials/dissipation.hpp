// SPDX-License-Identifier: Apache-2.0
// Elastic energy and plastic work of a point in a step of a plastic law, both per unit of volume
// before any flow.

#pragma once

#include "mpm_fem/materials/solid.hpp"

namespace elastogen {

struct StepWork {
  double elastic = 0;  ///< energy at the end of the step [J/m^3]
  double plastic = 0;  ///< work of the flow of the step [J/m^3], of metals with that of hardening
};

namespace detail {

/// tau.(e - e'): the work of the stress after the flow. For sand that of the deviator alone, since
/// opening and closing need no stress.
template <class L>
double flow_work(const L& law, const double s[3], const typename L::History& history) {
  constexpr int d = dimension<L>;
  const HenckyStrain<double, d> e = hencky_strain<d>(s);
  const Returned<double> r = law.template returned<false>(e, history);
  const bool deviator = std::is_same_v<L, DruckerPrager<double, d>>;
  double work = 0, mean = 0, lost = 0;
  for (int i = 0; i < d; ++i) {
    work += r.tau[i] * (e.e[i] - r.e[i]);
    mean += r.tau[i] / d, lost += e.e[i] - r.e[i];
  }
  return deviator ? work - mean * lost : work;
}

}  // namespace detail

/// Work in a step that ends at elastic trial stretches s. For laws with an energy the plastic work
/// is the excess of the step's potential over the elastic energy, exact for linear hardening.
template <class L>
StepWork step_work(const L& law, const double s[3], const typename L::History& history) {
  const double psi = law.template response<false>(s, history).psi;
  if constexpr (std::is_empty_v<typename L::History>) {
    return {psi, 0};
  } else if constexpr (has_energy<L>) {
    double end[3] = {s[0], s[1], s[2]};
    typename L::History after = history;
    law.commit(end, after);
    if (memory_of(after) == memory_of(history)) return {psi, 0};
    const double elastic = law.template response<false>(end, after).psi;
    return {elastic, psi - elastic};
  } else {
    return {psi, detail::flow_work(law, s, history)};
  }
}

}  // namespace elastogen
