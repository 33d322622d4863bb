// SPDX-License-Identifier: Apache-2.0
// What a solver holds, for the files that make it up: solver.cpp (the public face),
// step/solver_modes.cpp (which iteration a step takes), step/solver_step.cpp (a step).

#pragma once

#include "core/time_control.hpp"
#include "network/solver.hpp"
#include "network/step/cheaper_of.hpp"
#include "network/step/pass_budget.hpp"
#include "network/step/step_work.hpp"

#include <atomic>
#include <limits>
#include <optional>

namespace elastogen {

struct Solver::Impl {
  static constexpr double kAlways = std::numeric_limits<double>::infinity();  // in float64

  Impl(const Scene& scene, const SolverOptions& options);

  bool is_stiff() const;
  void make_work(const EncoderChoice* encoder);

  // which iteration improves u
  IterationResult quasi(double target, double precise_below);
  IterationResult newton(double target);
  IterationResult iterate(double target);
  IterationResult iterate_and_learn(double target, int64_t step);
  IterationResult choose(double target, int64_t step);
  double cost(const IterationResult& r) const;
  /// Polled once an iteration: a caller has ended the run, or the budget of the stage is spent.
  bool polled() { return options.interrupted() || budget.spend(); }
  bool stopped() const { return options.interrupted() || budget.spent(); }

  // the parts of a step
  void begin(const State& state);
  StepReport advance();
  bool start(StepReport& report);
  bool begins_by_extrapolation(int64_t step);
  void choose_start();
  IterationResult retreat(double target);
  bool solve(StepReport& report);
  void certify(StepReport& report);
  Span<const double> residual() const;
  /// What was solved did not converge; the published algorithm does not aim at that.
  bool is_draft(const StepReport& r) const {
    return r.finite && !r.converged && !r.interrupted && mode != SolverMode::kPaper;
  }
  void finish(StepReport& report);

  // steps of stages (solver_stages.cpp)
  StepReport advance_stages();
  bool make_stage(const TimeStage& stage, StepReport& report);
  bool make_step(TimeScheme kind, double h, StepReport& report);
  bool solve_with_lags(StepReport& report);
  bool judge(StepReport& report);
  void complete(StepReport& report, double end);
  double interval_end() const;
  double tolerance_of(const TimeStage& stage, double h);

  const Scene& scene;
  SolverOptions options;
  std::optional<PotentialTerms> terms;  // moved into the work, or held for its tables
  std::unique_ptr<StepWork> work;
  double force, courant;
  bool in_float;  // whether float has the digits for the scene
  bool pinned = false;
  bool extrapolates = false;  // where the predictor is not always the best start; then
  std::vector<CheaperOf> starts = std::vector<CheaperOf>(4, CheaperOf(20));  // of each mode
  int start_kind = 0;  // of the present step, 0: extrapolations too
  SolverMode mode;
  double last_cost[4] = {};  // of each mode
  int64_t last_step[4];      // that it took
  StepScheme scheme;
  TimeControl control;
  PassBudget budget;     // of the present stage
  double h_before = 0;   // of the step before [s]
  double tolerance = 0;  // of the present step
  bool between_intervals = true;
  bool lags = false;                // the last solve had friction or wind
  bool meets_collider = false;      // the last stage was not begun for it
  mutable Zeroed<double> gradient;  // of the last certificate, once it was asked for
  mutable bool has_gradient = true;

  // of a clip
  bool in_clip = false;
  bool has_before = false;  // there is a step before, for BDF2
  double time = 0;          // [s]
  int64_t steps = 0;
  bool carries = false;             // points for frames
  std::atomic<int64_t> frames = 0;  // started
};

}  // namespace elastogen
