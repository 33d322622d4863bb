// SPDX-License-Identifier: Apache-2.0
// A step of a solver, timed from a fixed state and compared with a reference.

#pragma once

#include "network/solver.hpp"

namespace elastogen::bench {

/// Mass-weighted rms distance of two sets of positions [m].
double rms(const Scene& scene, const Array<double>& a, const Array<double>& b);

struct Timing {
  StepReport report;
  double ms = 0;             ///< median
  double error = 0;          ///< rms distance to the reference over the rms motion of the step
  double setup_seconds = 0;  ///< of the solver
};

/// The median of several steps from the same state; a first one warms up.
Timing time_step(const Scene& scene, const State& start, const SolverOptions& options, int repeats,
                 const Array<double>& reference);

/// The state after some steps of newton at 1e-10, and the next one as reference.
struct Reference {
  State start, next;
};
Reference make_reference(const Scene& scene, const StartMotion& motion, int steps_before);

}  // namespace elastogen::bench
