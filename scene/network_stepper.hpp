// SPDX-License-Identifier: Apache-2.0
// Steps of the network, on the CPU or on a card.

#pragma once

#include "scene/stepper.hpp"

namespace elastogen {

/// A stepper for the solver options of a run. The scene must be finished and outlive it.
/// @throws Error as Solver.
std::unique_ptr<Stepper> make_network_stepper(const Scene& scene, const SolverOptions& options);

}  // namespace elastogen
