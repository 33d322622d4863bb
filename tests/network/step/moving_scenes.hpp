// SPDX-License-Identifier: Apache-2.0
// Scenes and states in motion for tests of steps.

#pragma once

#include "tests/network/device_support.hpp"

namespace elastogen::test {

/// A state in motion: turned, shaken, with a step before where BDF2 needs one.
inline State in_motion(const Scene& scene) {
  const StartMotion motion{.velocity = {0.3, -0.2, 0.5}, .spin = {2, -1, 3}};
  State state = initial_state(scene, motion);
  const std::vector<double> shake = random_field(scene, 0.05 * scene.grid.h, 4);
  state.x_before = state.x, state.v_before = state.v;
  for (int64_t k = 0; k < state.x.size(); ++k) {
    state.x.data()[k] += scene.dt * state.v.data()[k] + shake[size_t(k)];
    state.v.data()[k] *= 1.1;
  }
  return state;
}

/// Euler and BDF2 of three scenes.
inline std::vector<Scene> scenes() {
  std::vector<Scene> list;
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2})
    for (const auto& make : {beam_of_regions, falling_bar, three_blocks})
      list.push_back(make(scheme));
  return list;
}

}  // namespace elastogen::test
