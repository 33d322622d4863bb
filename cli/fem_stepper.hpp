// SPDX-License-Identifier: Apache-2.0
// A voxel scene stepped by finite elements on its voxels, or on tetrahedra that they are cut into;
// or the tetrahedra of a file.

#pragma once

#include "cli/stepper.hpp"
#include "mpm_fem/fem_scene.hpp"

namespace elastogen {

/// The scene as finite elements, on nodes of which the first are those of the grid.
/// @throws Error as add_boundary.
fem::FemScene fem_scene(const Setup& setup, const AnimateOptions& options);

/// What is asked of the residual of a run on that scene: --tolerance or, where that is not given,
/// 1e-8 or eight times 1.5 2^-52 3K/(rho g_ref h), which the rounding of stretches leaves at the
/// least (docs/physics.md, section 8).
double fem_tolerance(const Setup& setup, const AnimateOptions& options);

/// What a state file says of a run on that scene, but for its time scheme.
void describe_fem(const Setup& setup, const AnimateOptions& options, const fem::FemScene& scene,
                  StateHeader& header);

/// @throws Error as make_stepper.
std::unique_ptr<Stepper> make_fem_stepper(const Setup& setup, const AnimateOptions& options,
                                          std::function<bool()> interrupted);

}  // namespace elastogen
