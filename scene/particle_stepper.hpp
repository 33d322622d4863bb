// SPDX-License-Identifier: Apache-2.0
// Steps of particles.

#pragma once

#include "scene/stepper.hpp"

namespace elastogen {

/// Of the particles of a setup. A step is parted where particles would cross more than a cell of the
/// grid, and into halves where it does not converge.
/// @param stop  asked before each part of a step.
std::unique_ptr<Stepper> make_particle_stepper(const Setup& setup, const RunDescription& run,
                                               std::function<bool()> stop);

/// The longest part that a step of dt is taken in [s].
double longest_part(double dt);

}  // namespace elastogen
