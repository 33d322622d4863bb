// SPDX-License-Identifier: Apache-2.0
// Steps by particles.

#pragma once

#include "scene/stepper.hpp"

namespace elastogen {

/// A stepper for the particles of a setup. It divides a step if particles would cross more than a
/// cell of the grid, and halves a part that does not converge.
/// @param stop  polled before each part of a step.
std::unique_ptr<Stepper> make_particle_stepper(const Setup& setup, const RunDescription& run,
                                               std::function<bool()> stop);

/// The longest part into which a step of dt is divided [s].
double longest_part(double dt);

}  // namespace elastogen
