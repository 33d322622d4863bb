// SPDX-License-Identifier: Apache-2.0
// Times a step of a solver from a fixed state and compares it with a reference.

#pragma once

#include "network/solver.hpp"

namespace elastogen::bench {

constexpr int kStepsBefore = 2;  ///< from rest; the next step is timed again and again

/// Mass-weighted rms distance of two sets of positions [m].
double rms(const Scene& scene, const Array<double>& a, const Array<double>& b);

struct Timing {
  StepReport report;
  double ms = 0;             ///< median
  double error = 0;          ///< rms distance to the reference over the rms motion of the step
  double setup_seconds = 0;  ///< time to set up the solver
};

/// The median time of several steps from one state; a first step warms up.
Timing time_step(const Scene& scene, const State& start, const SolverOptions& options, int repeats,
                 const Array<double>& reference);

/// The state after some steps of newton at 1e-10, and the state after the next step as reference.
struct Reference {
  State start, next;
};
Reference make_reference(const Scene& scene, const StartMotion& motion, int steps_before);

}  // namespace elastogen::bench
