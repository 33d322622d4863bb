// SPDX-License-Identifier: Apache-2.0
// Steps of stages: SDIRK2 at a fixed length, and `auto`, whose steps follow their time error.
#include "core/constants.hpp"
#include "core/stopwatch.hpp"
#include "network/step/draft.hpp"
#include "network/step/solver_impl.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kOfTimeError = 0.01;     // that the solver may leave
constexpr double kLoosest = 0.3;          // residual
constexpr int kMostFriction = 30;         // solves for friction,
constexpr int kFirstFriction = 3;         // so many take all of its change, more of them
constexpr double kSettles = 0.7;          // where each lowers the residual by this at least,
constexpr double kLeastShare = 0.25;      // else a share that is halved each time,
constexpr int kMostWind = 40;             // and where wind blows
constexpr double kRough = 50;             // by which a solve for given ones lowers a residual
constexpr double kFiner = 0.3;            // by which solves in wind are finer, and every 4th again
constexpr double kMostGrowth = 2 + 1e-6;  // of BDF2's step over the one before

}  // namespace

/// The end of the interval dt of the scene that the present time lies in, or a break of a
/// path before it: no step goes across one.
double Solver::Impl::interval_end() const {
  const double dt = scene.dt;
  double end = (std::floor(time / dt + 1e-9) + 1) * dt;
  const auto stop_at = [&](const Path& path) {
    const double key = next_key(path, time + 1e-6 * dt);
    if (key < end - 1e-6 * dt) end = key;
  };
  for (const Collider& collider : scene.colliders) stop_at(collider.path);
  for (const Holder& holder : scene.holders) stop_at(holder.path);
  for (const TimedForce& force : scene.forces) stop_at(force.force);
  stop_at(scene.wind.velocity);
  return end;
}

/// Tolerance of a stage of a step of length h. A residual r moves nodes by about r g k^2: a hundredth
/// of the time error that the step may add is no loss.
double Solver::Impl::tolerance_of(const TimeStage& stage, double h) {
  if (scene.scheme != TimeScheme::kAuto || !options.follows_time_error) return options.tolerance;
  const double may_add = h / scene.dt * options.time_error * work->least_motion(scene.dt);
  const double enough = kOfTimeError * may_add / (kReferenceGravity * stage.k * stage.k);
  return std::max(options.tolerance, std::min(enough, kLoosest));
}

/// Solves a step in wind, or a stage with wind and friction, which depends on normal forces and
/// normals. A solve takes these as given: solves again until it has those of the positions that it ends
/// with. Each solve goes as far as it pays before they are taken anew. False where a solve was
/// interrupted.
bool Solver::Impl::solve_with_lags(StepReport& report) {
  const double wanted = tolerance;
  const bool blows = scene.wind.blows();
  bool solved = true, rough = lags;
  double share = 1, before = 0;  // of the change of friction that is taken, residual
  if (rough) tolerance = std::max(wanted, std::min(kRough * wanted, kLoosest));
  for (int pass = 0; solved; ++pass) {
    const int outer = report.outer, inner = report.inner;
    solved = solve(report);
    if (!solved) break;
    report.outer += outer;
    report.inner += inner;
    if (!report.finite) break;
    // the certificate is of the friction of the positions that are written
    lags = work->renew_lags();
    tolerance = wanted;
    if (lags) certify(report);
    report.converged = report.residual <= wanted;
    const int most = blows ? kMostWind : kMostFriction;
    if (report.converged || !(lags || rough) || pass == most || budget.spent()) break;
    // a residual r of light bodies changes the wind by more than r
    const double least = blows ? wanted * std::pow(kFiner, 1 + pass / 4) : wanted;
    tolerance = std::max(least, report.residual / kRough);
    rough = tolerance > wanted;
    if (pass >= kFirstFriction && report.residual > kSettles * before)
      share = std::max(share / 2, kLeastShare);
    before = report.residual;
    work->relax_lags(share);
  }
  tolerance = report.tolerance = wanted;
  return solved;
}

/// Solves a stage and adds it to the report of the step, which keeps the worst of all stages.
/// False where it was interrupted, refused or given up, or not begun because an impact is to come.
bool Solver::Impl::make_stage(const TimeStage& stage, StepReport& report) {
  StepReport own;
  own.step = report.step;
  scheme = StepScheme(report.scheme, stage);
  tolerance = tolerance_of(stage, report.length);
  bool solved = start(own);
  meets_collider = solved && scene.scheme == TimeScheme::kAuto &&
                   control.level() < TimeControl::kImpactLevel && work->meets_collider();
  if (meets_collider) return false;
  ++report.solves;
  // shorter steps are another way out, but for the shortest
  budget.begin(scene.scheme == TimeScheme::kAuto && control.level() < TimeControl::kMostLevel);
  solved = solved && solve_with_lags(own);
  if (own.converged) budget.learn(own.inner);
  if (is_draft(own)) own.refusal = why_draft(scene, own, residual());
  // counts add up, of the certificates the worst
  report.outer += own.outer;
  report.inner += own.inner;
  report.converged = report.converged && own.converged;
  report.residual = std::max(report.residual, own.residual);
  report.tolerance = std::max(report.tolerance, own.tolerance);
  report.float64 = report.float64 || own.float64;
  report.finite = report.finite && own.finite;
  report.min_j = std::min(report.min_j, own.min_j);
  report.min_corner_j = std::min(report.min_corner_j, own.min_corner_j);
  report.deepest_overlap = std::max(report.deepest_overlap, own.deepest_overlap);
  report.outside_fit = std::max(report.outside_fit, own.outside_fit);
  report.energy = own.energy;
  report.reactions = std::move(own.reactions);
  if (!own.refusal.empty()) report.refusal = own.refusal;
  report.interrupted = own.interrupted;
  return solved && own.finite && (own.converged || !budget.spent());
}

/// All stages of a step of length h.
bool Solver::Impl::make_step(TimeScheme kind, double h, StepReport& report) {
  // what earlier trials of the step have found counts no more, but for the work they took
  const StepReport trials = report;
  report = {};
  report.step = steps + 1;
  report.solves = trials.solves;
  report.rejected = trials.rejected;
  report.outer = trials.outer;
  report.inner = trials.inner;
  report.scheme = kind;
  report.length = h;
  report.converged = true;
  report.min_j = report.min_corner_j = 1e300;
  if (kind == TimeScheme::kEuler) return make_stage(euler_stage(h), report);
  if (kind == TimeScheme::kBdf2) return make_stage(bdf2_stage(h, h_before), report);
  if (!make_stage(sdirk2_stage(0, h), report)) return false;
  work->keep_stage();
  return make_stage(sdirk2_stage(1, h), report);
}

/// Ends a step and judges it. False: to be made again, on another level or by implicit Euler.
bool Solver::Impl::judge(StepReport& report) {
  const bool is_auto = scene.scheme == TimeScheme::kAuto;
  const TimeErrorOptions of_error{scene.dt, options.time_error};
  const StageEnd end = work->end_step(is_auto ? &of_error : nullptr);
  report.guarded = end.guarded;
  report.ledger = end.ledger;
  report.damped = end.ledger.done.damped;
  if (!is_auto) return true;
  report.time_error = end.error.estimate;
  report.time_ratio = end.error.ratio;
  return control.accepts(end.error.ratio) && end.keeps_energy;
}

/// Makes the end of an accepted step the state, and its time the present.
/// @param end  of the interval that the step lies in [s].
void Solver::Impl::complete(StepReport& report, double end) {
  finish(report);
  h_before = report.length;
  const bool is_last = report.length > (end - time) * (1 - 1e-9);
  time = is_last ? end : time + report.length;
  report.completes = is_last && std::abs(end / scene.dt - std::round(end / scene.dt)) < 1e-6;
  between_intervals = report.completes;
  report.time = time;
}

StepReport Solver::Impl::advance_stages() {
  const Stopwatch watch;
  const double end = interval_end(), left = end - time;
  const bool is_auto = scene.scheme == TimeScheme::kAuto;
  if (between_intervals && is_auto) control.begin_interval();
  between_intervals = false;
  StepReport report;
  report.solves = 0;
  bool by_euler = false;
  while (true) {
    // the kind of step of the present level; BDF2 needs a step before that is long enough
    const int level = control.level();
    const double h = is_auto ? control.step(left, scene.dt) : left;
    const bool by_bdf2 = is_auto && level == 0 && has_before && h < kMostGrowth * h_before;
    const TimeScheme kind = by_euler  ? TimeScheme::kEuler
                            : by_bdf2 ? TimeScheme::kBdf2
                                      : TimeScheme::kSdirk2;
    if (!make_step(kind, h, report)) {
      if (meets_collider) {  // not solved yet
        control.expect_impact();
        continue;
      }
      // shorter steps may be finite, or converge
      const bool may_retry = !report.interrupted && is_auto && level < TimeControl::kMostLevel;
      if (!may_retry) return report;
      control.accepts(kAlways);
      ++report.rejected;
      continue;
    }
    if (judge(report) || by_euler) break;
    // the error was accepted, so it was the energy that was not
    by_euler = report.time_ratio <= 1 || level == TimeControl::kMostLevel;
    ++report.rejected;
  }

  complete(report, end);
  report.ms = watch.milliseconds();
  return report;
}

}  // namespace elastogen
