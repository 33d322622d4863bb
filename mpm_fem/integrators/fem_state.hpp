// SPDX-License-Identifier: Apache-2.0
// State of a finite element run, and functions that its steps share: float64, plain arrays.

#pragma once

#include "mpm_fem/fem/plastic_body.hpp"
#include "mpm_fem/fem_scene.hpp"
#include "mpm_fem/integrators/stage_history.hpp"
#include "mpm_fem/solve/mass_matrix.hpp"

namespace elastogen::fem {

struct FemState {
  Array<double> u;    ///< displacements [m], (nodes, 3)
  Array<double> v;    ///< velocities [m/s], (nodes, 3)
  Array<double> a;    ///< accelerations [m/s^2], (nodes, 3); Newmark only, empty before its start
  double time = 0;    ///< [s]
  int64_t steps = 0;  ///< steps taken since the start

  // the step before, for BDF2; filled by step
  Array<double> u_before;  ///< (nodes, 3); empty: the next step is implicit Euler
  Array<double> v_before;  ///< (nodes, 3)

  StageHistory stages;  ///< of steps of stages; filled by StageFem::step

  // of the elements that yield, in their order; filled by step
  PlasticHistory plastic;   ///< at the end of the last step; empty: before any flow
  double plastic_work = 0;  ///< since the start [J]
};

/// At rest, undeformed.
FemState rest_state(const FemScene& scene);

/// @throws Error unless the arrays of a state are (nodes, 3), u_before and v_before both or neither.
void check_state(const FemState& state, int64_t nodes);

/// Norm of the weights of the free nodes [N], 9.81 m/s^2 times the 2-norm of their masses: the unit
/// of residuals (docs/physics.md). A node is free if a component of it is and it is not dependent.
double reference_force(const FemScene& scene, const Array<double>& nodal_mass);

/// Traction and additional forces at a time, (nodes, 3) [N], without gravity.
Array<double> applied_force(const FemScene& scene, double time, double traction_share);

/// u with the fixed components that scene.motion prescribes at a time.
Array<double> with_motion(const FemScene& scene, double time, const Array<double>& u);

/// What scene.dependent_motion adds to dependent nodes at a time [m], (dependent nodes, 3).
Array<double> dependent_offset(const FemScene& scene, double time);

}  // namespace elastogen::fem
