// SPDX-License-Identifier: Apache-2.0
// Static equilibrium under gravity, dead loads and prescribed displacements, along a load factor
// from 0 to 1 in increments that shrink where Newton's method fails and grow where it does not.
// Materials that yield commit their flow after each increment.

#pragma once

#include "mpm_fem/integrators/fem_state.hpp"
#include "mpm_fem/solve/potential.hpp"

namespace elastogen::fem {

struct StaticOptions {
  /// Bound of |grad Phi| over the free components, relative to the forces of the increment: the
  /// larger of the 2-norms of the loads and of the forces that hold fixed components.
  double tolerance = 1e-10;
  double first_increment = 1;        ///< of the load factor
  double smallest_increment = 1e-4;  ///< below it the solver gives up
  double largest_flow = 1.0 / 16;    ///< largest increment where a material yields
  int max_newton = 40;               ///< Newton steps of an increment
  LinearOptions linear = {};
};

struct StaticResult {
  /// Full load, and the residual within the tolerance or, up to 1e-4, within its rounding error.
  bool converged = false;
  double load_factor = 0;  ///< load factor of u
  Array<double> u;         ///< [m], (nodes, 3)
  /// Forces that hold the fixed components [N], (nodes, 3), else 0. What holds dependent nodes has
  /// the opposite of their part in their parent nodes: sums are the forces of the border.
  Array<double> reaction;
  PlasticHistory plastic;  ///< at u, of the elements that yield; empty: none does
  Array<double> gradient;  ///< remaining forces [N], (nodes, 3), as Potential::evaluate has them
  EnergyParts energy;      ///< at u; gravity as -sum m g.u
  double min_j = 1;
  int increments = 0;    ///< that were accepted
  int newton_steps = 0;  ///< of all, failed ones included

  // of the last increment, even if it failed and u is that of the one before
  NewtonStop stop = NewtonStop::kConverged;
  double residual = 0;  ///< relative, as the tolerance
  double floor = 0;     ///< bound on its rounding error, relative; 0 if not needed
};

/// Rotations of the voxels' torsion correction are those of the solution: they are frozen anew
/// until that changes nothing.
/// @throws Error as FemPotential, on damping and on options that are not positive.
StaticResult solve_static(const FemScene& scene, const StaticOptions& options = {});

}  // namespace elastogen::fem
