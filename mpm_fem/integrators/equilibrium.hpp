// SPDX-License-Identifier: Apache-2.0
// Finds where the forces of a step's potential vanish. For materials without a potential, sand and
// snow, Newton's method works on the true forces and has no energy that must fall. So a few steps
// on potentials frozen at the present state come first, and another one where its line search
// fails.

#pragma once

#include "mpm_fem/integrators/fem_potential.hpp"

namespace elastogen::fem {

struct Equilibrium {
  NewtonStop stop = NewtonStop::kConverged;
  int iterations = 0;  ///< linear systems solved
  int fallbacks = 0;   ///< frozen steps after steps on the true forces failed or were slow
  double noise = 0;    ///< bound on the rounding error of the forces [N]; 0: not needed
};

/// Moves u towards the equilibrium; the materials are thawed when it returns.
/// @param options  tolerance of the 2-norm of the forces on free components [N]
Equilibrium find_equilibrium(FemPotential& terms, const NewtonOptions& options, double* u);

}  // namespace elastogen::fem
