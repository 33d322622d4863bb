// SPDX-License-Identifier: Apache-2.0
// A step on either machine: where it starts, how it is solved, how it ends.
#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "network/step/draft.hpp"
#include "network/step/predictor.hpp"
#include "network/step/solver_impl.hpp"

#include <cmath>

namespace elastogen {

/// Takes the time, the steps and the order of a state that the work has got.
void Solver::Impl::begin(const State& state) {
  has_before = !state.x_before.empty();
  h_before = state.h_before > 0 ? state.h_before : scene.dt;
  time = state.time;
  steps = state.steps;
}

/// Extrapolations save iterations where forces go on as they were; where waves run through a body
/// the predictor, far away as it is, can do with fewer: it leaves errors that iterations find soon.
bool Solver::Impl::begins_by_extrapolation(int64_t step) {
  if (!extrapolates && !scheme.is_stage) return false;
  start_kind = starts[size_t(mode)].choose(step);
  return start_kind == 0;
}

/// The start of lowest Phi among the predictor's and the extrapolations.
void Solver::Impl::choose_start() {
  double phi[3];
  const int orders = scheme.is_stage ? 1 + (scheme.stage.t_b != 0) : Predictor::orders(has_before);
  const int count = 1 + orders;
  work->evaluate_starts(count, phi);
  int best = 0;
  for (int k = 1; k < count; ++k)
    if (phi[k] < phi[best] || std::isnan(phi[best])) best = k;
  work->use_start(best);
}

/// Predictor, inertia and rotations of the step, and u where it starts: the chosen start, cut where
/// it would carry a surface point into a collider, or the clear start where u leaves that by more
/// than a voxel and has the higher potential (a small pinned body falls many times its size in a
/// step). False, with the refusal, where a point lies in a collider all the same.
bool Solver::Impl::start(StepReport& report) {
  work->begin_step(scheme, time);
  if (mode == SolverMode::kPaper) return true;  // it starts at the predictor itself
  if (begins_by_extrapolation(report.step)) choose_start();
  const bool is_far = pinned && work->farthest() >= scene.grid.h;
  if (const Collider* inside = work->clear_start()) {
    report.finite = false;
    report.refusal = concat("collider '", inside->name, "' runs into a part that cannot give way (",
                            "pinned, or held by another collider)");
    return false;
  }
  if (is_far && !work->is_below_clear_start()) work->return_to_clear_start();
  work->set_nodal_rotations();
  return true;
}

/// Where the iterations ended above the potential of the state before, they begin there once more,
/// held nodes where they are to be: a step that ends at or below it, converged or not, brings no energy (Phi there is the energy at
/// the start of the step, and no less than that at its end).
IterationResult Solver::Impl::retreat(double target) {
  if (!(work->phi_now() < work->phi())) return {};
  work->return_to_now();
  return newton(target);
}

void Solver::Impl::certify(StepReport& report) {
  const Certificate certificate = work->certify();
  has_gradient = false;
  const PotentialValue& value = certificate.value;
  report.residual = force > 0 ? certificate.size / force : 0;
  report.converged = report.residual <= tolerance;
  report.tolerance = tolerance;
  report.finite = certificate.finite;
  report.reactions = certificate.reactions;
  report.min_j = value.min_j;
  report.min_corner_j = value.min_corner_j;
  report.deepest_overlap = value.deepest_overlap / scene.grid.h;
  report.energy.elastic = value.elastic;
  report.energy.hourglass = value.hourglass;
  report.energy.contact = value.contact;
  report.damped = scheme.dt * damping_power(value, scheme);  // of stages the ledger has it
  report.outside_fit = value.outside;
}

/// The gradient of the last certificate, (nodes, 3).
Span<const double> Solver::Impl::residual() const {
  if (!has_gradient) work->download_gradient(gradient.data());
  has_gradient = true;
  return {gradient.data(), int64_t(gradient.size() / 3), 3};
}

/// Iterates and certifies; false where the step was given up on request.
bool Solver::Impl::solve(StepReport& report) {
  // a margin, because the state that is written is rounded once more
  const double target = 0.95 * tolerance * force;
  const bool is_paper = mode == SolverMode::kPaper;
  IterationResult result = choose(target, report.step);
  if (!result.converged && !is_paper && !stopped()) result = sum(result, retreat(target));
  report.interrupted = options.interrupted();
  if (report.interrupted) return false;
  certify(report);

  // what float called converged may not be
  if (!report.converged && !result.float64 && report.finite && !is_paper) {
    result = sum(result, quasi(target, kAlways));
    certify(report);
  }
  report.float64 = result.float64;
  report.outer = result.outer;
  report.inner = result.inner;
  return true;
}

void Solver::Impl::finish(StepReport& report) {
  const MotionEnergy energy = work->finish();
  report.energy.kinetic = energy.kinetic;
  report.energy.gravity = energy.gravity;
  has_before = true;
  ++steps;
  if (!scheme.is_stage) time = double(steps) * scene.dt;
}

StepReport Solver::Impl::advance() {
  if (has_stages(scene.scheme)) return advance_stages();
  const Stopwatch watch;
  StepReport report;
  scheme = step_scheme(scene, has_before);
  tolerance = options.tolerance;
  report.scheme = scheme.scheme;
  report.step = steps + 1;
  report.length = scene.dt;
  report.time = double(report.step) * scene.dt;
  if (!start(report)) return report;
  if (!(scene.wind.blows() ? solve_with_lags(report) : solve(report))) return report;
  if (is_draft(report)) report.refusal = why_draft(scene, report, residual());
  if (report.finite) finish(report);
  report.ms = watch.milliseconds();
  return report;
}

}  // namespace elastogen
