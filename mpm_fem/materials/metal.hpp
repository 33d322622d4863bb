// SPDX-License-Identifier: Apache-2.0
// What the metals share: von Mises' radius grows with the flow that they remember.

#pragma once

#include "mpm_fem/materials/return_map.hpp"

namespace elastogen {

/// What a metal remembers: its flow, the sum of |plastic strain increment| [-].
template <class T>
struct FlowHistory {
  T flow = 0;
};

/// Ends the step of a metal: what its map leaves; what the deviator lost is flow.
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
