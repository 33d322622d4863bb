// SPDX-License-Identifier: Apache-2.0
// The state of a run: what a step reads and writes. float64 always.

#pragma once

#include "core/array.hpp"

namespace elastogen {

struct Scene;

struct State {
  // the present; filled by initial_state, then by step
  Array<double> x;    ///< positions [m], (nodes, 3)
  Array<double> v;    ///< velocities [m/s], (nodes, 3)
  double time = 0;    ///< [s]
  int64_t steps = 0;  ///< steps taken since the start

  // the step before, for BDF2; filled by step
  Array<double> x_before;  ///< (nodes, 3); empty: the next step is implicit Euler
  Array<double> v_before;  ///< (nodes, 3)
  double h_before = 0;     ///< its length [s]; 0: the dt of the scene
};

/// What the last step has beside the state, for those who recompute it. Valid until the next step.
struct StageData {
  // of steps of stages
  Span<const double> first;  ///< positions at the end of SDIRK2's first stage [m], (nodes, 3)
  Span<const double> bonds;  ///< slip that friction holds now [m], (colliders points, 3); empty: 0
  // where loads change
  Span<const double> load;        ///< on each node at the end of the step [N], (nodes, 3)
  Span<const double> first_load;  ///< the same of SDIRK2's first stage
};

/// Parts to read of a state that is stepped elsewhere: the positions alone, or all.
enum class StateParts { kPositions, kAll };

/// A uniform velocity and a spin [rad/s] about the centre of mass.
struct StartMotion {
  double velocity[3] = {0, 0, 0};
  double spin[3] = {0, 0, 0};
};

/// The rest state with a rigid motion; pinned nodes stand where they are held. Needs a finished scene.
State initial_state(const Scene& scene, const StartMotion& motion = {});

/// @throws Error naming the array, and the place of the first number that is not finite, unless all
///         arrays are (nodes, 3) and finite.
void check_state(const State& state, int64_t nodes);

}  // namespace elastogen
