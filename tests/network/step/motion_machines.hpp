// SPDX-License-Identifier: Apache-2.0
// Runs of the scenes of motion_scenes.hpp on either machine.

#pragma once

#include "tests/network/step/motion_scenes.hpp"
#include "tests/support/on_card.hpp"

namespace elastogen::test {

using MotionOnCard = OnCard;

inline constexpr TimeScheme kAuto = TimeScheme::kAuto, kSdirk2 = TimeScheme::kSdirk2;

/// A run on a machine, with a tolerance of its own at the default one.
inline std::vector<MotionFrame> play_on(Device device, const MovingScene& m, TimeScheme scheme,
                                        int frames) {
  return play(m, scheme, frames, 1, {.device = device});
}

/// The same with each stage solved to a tolerance.
inline std::vector<MotionFrame> play_exactly(Device device, const MovingScene& m, TimeScheme scheme,
                                             int frames, double tolerance) {
  SolverOptions options;
  options.device = device;
  options.tolerance = tolerance;
  options.follows_time_error = false;
  return play(m, scheme, frames, 1, options);
}

}  // namespace elastogen::test
