// SPDX-License-Identifier: Apache-2.0
// Where the forces of a step's potential vanish. Materials without a potential, sand and snow, are
// solved by Newton's method on the true forces, which has no energy to go down: a few steps on
// potentials frozen at the present state bring it near, and one helps where its line search fails.

#pragma once

#include "mpm_fem/integrators/fem_potential.hpp"

namespace elastogen::fem {

struct Equilibrium {
  NewtonStop stop = NewtonStop::kConverged;
  int iterations = 0;  ///< linear systems solved
  int fallbacks = 0;   ///< frozen steps where those on the true forces failed or crept
  double noise = 0;    ///< bound on the rounding error of the forces [N]; 0: nobody had to ask
};

/// Moves u towards it; the materials are thawed when it returns.
/// @param options  tolerance of the 2-norm of the forces on what is free [N]
Equilibrium find_equilibrium(FemPotential& terms, const NewtonOptions& options, double* u);

}  // namespace elastogen::fem
