// SPDX-License-Identifier: Apache-2.0
// A run as finite elements on its voxels, on tetrahedra that they are cut into, or on the
// tetrahedra of a file.

#pragma once

#include "io/state_writer.hpp"
#include "mpm_fem/fem/plastic_body.hpp"
#include "mpm_fem/fem_scene.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// The scene as finite elements, on nodes of which the first are those of the grid.
/// @throws Error as add_boundary.
fem::FemScene fem_scene(const Setup& setup, const RunDescription& run);

/// What is asked of the residual of a run on that scene: the tolerance or, where rounding may raise
/// it, eight times 1.5 2^-52 3K/(rho g_ref h), which the rounding of stretches leaves at the least
/// (docs/physics.md, section 8).
double fem_tolerance(const Setup& setup, const RunDescription& run);

/// What a state file says of a run on that scene, but for its time scheme.
void describe_fem(const Setup& setup, const RunDescription& run, const fem::FemScene& scene,
                  StateHeader& header);

/// What a state file keeps of the flow; none where no material yields.
std::optional<StatePlastic> state_plastic(const fem::FemScene& scene,
                                          const fem::PlasticHistory& history);

}  // namespace elastogen
