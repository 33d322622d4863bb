// SPDX-License-Identifier: Apache-2.0
// Shared by the metals: von Mises' radius, which grows with the flow so far.

#pragma once

#include "mpm_fem/materials/return_map.hpp"

namespace elastogen {

/// History of a metal: its flow, the sum of |plastic strain increment| [-].
template <class T>
struct FlowHistory {
  T flow = 0;
};

/// Ends the step of a metal: applies its map, and adds the deviator that it removes to the flow.
template <int d, class Law, class T>
ELASTOGEN_HD inline Returned<T> commit_flow(const Law& law, const HenckyStrain<T, d>& e,
                                            FlowHistory<T>& history) {
  const Returned<T> r = law.template returned<false>(e, history);
  T lost[3] = {};
  for (int i = 0; i < d; ++i) lost[i] = e.e[i] - r.e[i];
  history.flow += split_strain<d>(lost).size;
  return r;
}

}  // namespace elastogen
