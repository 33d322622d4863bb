// SPDX-License-Identifier: Apache-2.0
// Steps of finite elements.

#pragma once

#include "scene/stepper.hpp"

namespace elastogen {

/// On what fem_scene makes of the run.
/// @param stop  asked before each step.
/// @throws Error as fem_scene.
std::unique_ptr<Stepper> make_fem_stepper(const Setup& setup, const RunDescription& run,
                                          std::function<bool()> stop);

}  // namespace elastogen
