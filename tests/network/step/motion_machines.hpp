// SPDX-License-Identifier: Apache-2.0
// Runs of the scenes of motion_scenes.hpp on either machine.

#pragma once

#include "tests/network/step/motion_scenes.hpp"
#include "tests/support/on_card.hpp"

namespace elastogen::test {

using MotionOnCard = OnCard;

/// A run on a machine at the default tolerance.
inline std::vector<MotionFrame> play_on(Device device, const MovingScene& m, TimeScheme scheme,
                                        int frames) {
  return play(m, scheme, frames, 1, {.device = device});
}

}  // namespace elastogen::test
