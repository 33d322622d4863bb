// SPDX-License-Identifier: Apache-2.0
// Steps by finite elements.

#pragma once

#include "scene/stepper.hpp"

namespace elastogen {

/// A stepper on the scene that fem_scene makes of the run.
/// @param stop  polled before each step, part of a step or trial.
/// @throws Error as fem_scene, and as the integrator of the scheme.
std::unique_ptr<Stepper> make_fem_stepper(const Setup& setup, const RunDescription& run,
                                          std::function<bool()> stop);

}  // namespace elastogen
