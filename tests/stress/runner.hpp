// SPDX-License-Identifier: Apache-2.0
// A stress case, its record, and the run of a scene with the checks for every scene: finite states,
// an honest "converged", no energy from nowhere, equal bits in a second run.

#pragma once

#include "core/error.hpp"
#include "network/solver.hpp"

#include <functional>
#include <string>
#include <vector>

namespace elastogen::stress {

/// Record of a case. It passed if there are no faults.
struct Record {
  std::string name;
  std::string label;  ///< how it ended, in words: "at rest", "refused: ..."; counted in the summary
  std::vector<std::string> notes;  ///< numbers worth reading
  std::vector<std::string> faults;
  std::vector<int> iterations;  ///< evaluations or PCG iterations of each step
  int64_t drafts = 0, refusals = 0;
  bool float64 = false;          ///< some step ran in double precision
  double first_float64 = 1e300;  ///< smallest estimate of the float floor at which one did
  double seconds = 0;

  /// Keeps the fault that the message describes unless the condition holds.
  template <class... Parts>
  void expect(bool condition, const Parts&... parts) {
    if (!condition) faults.push_back(concat(parts...));
  }
  template <class... Parts>
  void note(const Parts&... parts) {
    notes.push_back(concat(parts...));
  }
};

struct Case {
  std::string name;
  bool brief;  ///< in the short set
  std::function<void(Record&)> run;
};

/// How a scene is run and which of the general checks apply.
struct Plan {
  int steps = 20;
  SolverOptions options = {};
  bool passive = true;           ///< energy must not rise; off for the published algorithm
  int check_every = 1;           ///< steps between recomputed equations
  int repeated_steps = 1 << 30;  ///< the second run is cut here
  /// Changes the scene before a step (counted from 0).
  std::function<void(Scene&, int)> before_step = {};
  /// Whether the run has reached its goal.
  std::function<bool(const State&, const StepReport&)> done = {};
};

struct Outcome {
  State state;
  std::vector<StepReport> reports;
};

/// Runs the scene from a state with two threads and checks, then again with one thread and compares
/// the hashes. An Error ends the run as refused.
Outcome run(Record& record, Scene& scene, const State& start, const Plan& plan);

/// Runs the scene without any check, for measurements.
Outcome plain_run(Scene& scene, const State& start, const Plan& plan);

/// Expects that the action throws an Error of that kind, whose message becomes the label.
void expect_error(Record& record, const std::function<void()>& action, ErrorKind kind);

/// FNV-1a of positions and velocities.
uint64_t hash(const State& state);

/// Memory of the process [bytes]: now, and the peak since forget_peak().
int64_t resident_memory();
int64_t peak_memory();
void forget_peak();

}  // namespace elastogen::stress
