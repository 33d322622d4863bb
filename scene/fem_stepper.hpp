// SPDX-License-Identifier: Apache-2.0
// Steps by finite elements.

#pragma once

#include "scene/stepper.hpp"

namespace elastogen {

/// A stepper on the scene that fem_scene makes of the run.
/// @param stop  polled before each step.
/// @throws Error as fem_scene.
std::unique_ptr<Stepper> make_fem_stepper(const Setup& setup, const RunDescription& run,
                                          std::function<bool()> stop);

}  // namespace elastogen
