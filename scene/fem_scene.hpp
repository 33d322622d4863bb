// SPDX-License-Identifier: Apache-2.0
// A run as finite elements: on its voxels, on tetrahedra cut from them, or on those of a file.

#pragma once

#include "io/state_writer.hpp"
#include "mpm_fem/fem/plastic_body.hpp"
#include "mpm_fem/fem_scene.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// The elements of a run, before pins cut them.
fem::ElementMesh whole_mesh(const Setup& setup, const RunDescription& run);

/// The scene as finite elements. The first of their nodes are those of the grid.
/// @throws Error as add_boundary.
fem::FemScene fem_scene(const Setup& setup, const RunDescription& run);

/// The tolerance of the residual on that scene. If rounding may raise it, it is at least eight
/// times 1.5 2^-52 3K/(rho g_ref h), the least residual that the rounding of stretches leaves
/// (docs/physics.md, section 8).
double fem_tolerance(const Setup& setup, const RunDescription& run);

/// Fills the header of a state file for a run on that scene, except for its time scheme.
void describe_fem(const Setup& setup, const RunDescription& run, const fem::FemScene& scene,
                  StateHeader& header);

/// The plastic state for a state file; none if no material yields.
std::optional<StatePlastic> state_plastic(const fem::FemScene& scene,
                                          const fem::PlasticHistory& history);

}  // namespace elastogen
