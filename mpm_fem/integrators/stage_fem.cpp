// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/stage_fem.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/reduce.hpp"
#include "core/scene.hpp"
#include "core/stopwatch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen::fem {
namespace {

constexpr double kOfTimeError = 0.01;     // that a residual may leave
constexpr double kLoosest = 0.3;          // residual
constexpr int kMostFriction = 30;         // solves of a stage for its friction without wind,
constexpr int kFirstFriction = 4;         // after so many only a part of its change is taken
constexpr double kSettles = 0.7;          // where the residual did not fall to this share
constexpr double kMostGrowth = 2 + 1e-6;  // of a step of BDF2 over the one before
constexpr double kNever = std::numeric_limits<double>::infinity();

bool is_driven(const FemScene& scene) {
  const bool moves = std::any_of(scene.colliders.begin(), scene.colliders.end(),
                                 [](const Collider& c) { return c.path.moves(); });
  return moves || scene.motion || scene.dependent_motion || scene.force || scene.in_wind ||
         !scene.traction.empty();
}

/// Adds a stage to the report of its step: the worst of both, energies of the last one.
void add_stage(const FemStepReport& stage, FemStepReport& step) {
  step.outer += stage.outer;
  step.converged &= stage.converged;
  step.finite &= stage.finite;
  step.float64 = true;
  step.residual = std::max(step.residual, stage.residual);
  step.floor = std::max(step.floor, stage.floor);
  step.tolerance = std::max(step.tolerance, stage.tolerance);
  step.min_j = std::min(step.min_j, stage.min_j);
  step.deepest_overlap = std::max(step.deepest_overlap, stage.deepest_overlap);
  step.energy = stage.energy;
  if (stage.stop != NewtonStop::kConverged) step.stop = stage.stop;
  if (!stage.refusal.empty()) step.refusal = stage.refusal;
}

}  // namespace

StageFem::StageFem(const FemScene& scene, const StageOptions& options)
    : scene_(scene),
      options_(options),
      solve_(scene, options.solve),
      terms_(solve_.terms()),
      potential_(terms_.potential),
      pieces_(scene, potential_.mass()),
      motion_(scene, pieces_),
      is_driven_(is_driven(scene)),
      applied_(scene) {
  ELASTOGEN_CHECK(scene.scheme == Scheme::kSdirk2 || scene.scheme == Scheme::kAuto,
                  "a scheme of stages is sdirk2 or auto");
  ELASTOGEN_CHECK(!terms_.plastic, "a material that yields is not for sdirk2 and auto: their ",
                  "rejected steps cannot take its flow back");
  ELASTOGEN_CHECK(options.time_error > 0, "the time error must be positive, got ",
                  options.time_error);
}

/// The end of the interval dt that the present time lies in, or a break of a path before it: no step
/// goes across one.
double StageFem::interval_end() const {
  const double dt = scene_.dt, close = 1e-6 * dt;
  double end = dt * (std::floor(now_->time / dt + 1e-9) + 1);
  const auto stop_at = [&](const Path& path) {
    const double key = next_key(path, now_->time + close);
    if (key < end - close) end = key;
  };
  for (const Collider& collider : scene_.colliders) stop_at(collider.path);
  for (const Path& path : scene_.paths) stop_at(path);
  if (scene_.in_wind) stop_at(scene_.in_wind->wind.velocity);
  return end;
}

/// BDF2 on the lowest level, where the step before is long enough; else SDIRK2.
TimeScheme StageFem::kind_of(double h) const {
  const double before = now_->u_before.empty() ? 0 : now_->stages.h_before;
  const bool lowest = scene_.scheme == Scheme::kAuto && control_.level() == 0;
  return lowest && h < kMostGrowth * before ? TimeScheme::kBdf2 : TimeScheme::kSdirk2;
}

/// Tolerance of a stage of a step of length h. A residual r moves nodes by about r g k^2: a
/// hundredth of the time error that the step may add is no loss.
double StageFem::tolerance_of(const TimeStage& stage, double h) const {
  const double asked = options_.solve.tolerance;
  if (scene_.scheme != Scheme::kAuto || !options_.follows_time_error) return asked;
  const double may_add = h / scene_.dt * options_.time_error * least_motion();
  const double enough = kOfTimeError * may_add / (kReferenceGravity * stage.k * stage.k);
  return std::max(asked, std::min(enough, kLoosest));
}

/// Sets the potential of a stage.
void StageFem::begin_stage(const TimeStage& stage) {
  const double start = now_->time;
  motion_.begin_stage(stage);
  terms_.move_dependent(start + stage.t);
  applied_.begin(start + stage.t, stage.k);
  if (stage.t_b <= 0) applied_.start_wind(now_->u, now_->v);
  potential_.set_force(applied_.force());
  potential_.set_inertia(1 / (stage.k * stage.k), motion_.predictor());
  terms_.begin_damping(1 / stage.k, now_->u, stage.w_v, stage.t_b > 0 ? u_ : now_->u_before);
  if (!terms_.contact.exists()) return;
  // friction begins with the normal forces where the last solve ended
  const bool is_second = stage.t_b > 0;
  terms_.contact.begin_stage(now_->u, start, stage.t, is_second ? u_ : now_->u,
                             is_second ? start + stage.t_b : start, now_->stages.bonds);
}

/// Takes friction and wind from where the last solve ended. False where there is none.
bool StageFem::renew_lags() {
  const bool rubs = terms_.contact.exists() && terms_.contact.renew_lags(u_);
  if (!applied_.blows()) return rubs;
  applied_.take_wind(u_, motion_.velocities(u_));
  potential_.set_force(applied_.force());
  return true;
}

/// Friction depends on normal forces and normals that a solve takes as given, as it does wind: solves
/// again until the residual holds with those of the displacements that it ends with.
void StageFem::minimise(double tolerance, Array<double>& u, FemStepReport& report) {
  u_ = solve_.minimise(tolerance, u, report);
  double share = 1, before = 0;
  for (int solves = 1; report.finite && renew_lags(); ++solves) {
    solve_.certify(tolerance, u_, report);
    if (report.converged || solves == (applied_.blows() ? kMostWind : kMostFriction)) return;
    if (solves >= kFirstFriction && report.residual > kSettles * before)
      share = std::max(0.25, share / 2);
    before = report.residual;
    if (share < 1 && terms_.contact.exists()) terms_.contact.relax_lags(share);
    applied_.relax_wind();
    potential_.set_force(applied_.force());
    u_ = solve_.minimise(tolerance, u, report);
  }
}

/// Whether a body in flight, fast enough for a bounce that counts, will meet a collider on its way to
/// predicted displacements.
bool StageFem::meets_collider(const Array<double>& predicted) {
  if (scene_.scheme != Scheme::kAuto || control_.level() >= TimeControl::kImpactLevel) return false;
  for (const PieceLoad& piece : now_->stages.now.pieces)
    if (piece.push > 0) return false;
  bool fast = false;
  const std::vector<PieceMotion> motions = pieces_.motions(now_->u, now_->v);
  for (size_t p = 0; p < pieces_.count(); ++p)
    fast |=
        pieces_.is_loose(p) && bounce_counts(safe_norm(motions[p].velocity),
                                             safe_norm(scene_.gravity), scene_.dt, pieces_.size(p));
  return fast && terms_.contact.exists() && terms_.contact.obstacle(predicted);
}

/// Solves a stage, which leaves u_. False where that is not finite, or an impact is to come.
bool StageFem::make_stage(const TimeStage& stage, FemStepReport& report) {
  begin_stage(stage);
  FemStepReport own;
  own.tolerance = tolerance_of(stage, report.length);
  std::vector<Array<double>> starts = motion_.starts();
  meets_collider_ = meets_collider(starts.front());
  if (meets_collider_) return false;
  if (stage.t_b > 0) starts.push_back(u_);
  Array<double> u = solve_.start_value(now_->u, std::move(starts), now_->time + stage.t);
  const bool clear = solve_.pass_colliders(u);
  minimise(own.tolerance, u, own);
  if (!clear) own.finite = false, own.refusal = kNoRoom;
  ++report.solves;
  add_stage(own, report);
  return own.finite;
}

/// All stages of a step of length h. The report keeps of earlier trials what they cost.
bool StageFem::make_step(TimeScheme kind, double h, FemStepReport& report) {
  const FemStepReport trials = report;
  report = {};
  report.step = now_->steps + 1;
  report.solves = trials.solves;
  report.rejected = trials.rejected;
  report.outer = trials.outer;
  report.scheme = kind;
  report.used = kind == TimeScheme::kEuler  ? Scheme::kEuler
                : kind == TimeScheme::kBdf2 ? Scheme::kBdf2
                                            : Scheme::kSdirk2;
  report.length = h;
  report.time = now_->time + h;
  report.converged = true;
  report.min_j = kNever;
  at_stage_ = {};
  // one stage, or two
  if (kind == TimeScheme::kEuler) return make_stage(euler_stage(h), report);
  if (kind == TimeScheme::kBdf2) return make_stage(bdf2_stage(h, now_->stages.h_before), report);
  if (!make_stage(sdirk2_stage(0, h), report)) return false;
  at_stage_ = actions_at(u_);
  booking_.at_first = actions(motion_.velocities(u_), at_stage_);
  motion_.keep_stage(u_);
  first_ = u_;
  first_loads_ = applied_.force();
  return make_stage(sdirk2_stage(1, h), report);
}

/// Ends a step and judges it. False: to be made again.
bool StageFem::judge(FemStepReport& report) {
  v_ = motion_.velocities(u_);
  end_ = pieces_.motions(u_, v_);
  at_end_ = actions_at(u_);
  booking_.at_end = actions(v_, at_end_);
  holding_ = Array<double>(u_.rows(), 3);
  potential_.held_gradient(u_.data(), scene_.gravity, holding_.data());
  booking_.kinetic = pieces_.product(v_, v_) / 2;
  correct_momentum();
  booking_.corrected = account_of(u_, v_);
  const bool keeps_energy = guard(report.energy.elastic + report.energy.hourglass);
  report.guarded = guarded_;
  write_ledger(report);
  remember_speeds(report.length / scene_.dt);
  if (scene_.scheme == Scheme::kSdirk2) return true;
  const TimeError found = error();
  report.time_error = found.estimate;
  report.time_ratio = found.ratio;
  return control_.accepts(found.ratio) && keeps_energy;
}

/// Makes the end of an accepted step the state.
void StageFem::complete(double end, FemState& state, FemStepReport& report) {
  // energies of the motion
  report.energy.kinetic = pieces_.product(v_, v_) / 2;
  const double* weight = solve_.weight().data();
  for (int64_t k = 0; k < u_.size(); ++k)
    report.energy.gravity -= weight[k] * (scene_.mesh.rest.data()[k] + u_.data()[k]);
  // what the next step needs to know
  StageHistory& history = state.stages;
  history.h_before = report.length;
  history.before = std::move(history.now);
  history.now = std::move(at_end_);
  history.elastic_energy = report.energy.elastic + report.energy.hourglass;
  history.pieces = std::move(memory_);
  history.ledger = report.ledger;
  history.control = control_;
  if (terms_.contact.exists()) history.bonds = terms_.contact.bonds(u_);
  // the state, its time rounded to the end of the interval where it ends there
  const bool is_last = report.length > (end - state.time) * (1 - 1e-9);
  state.u_before = std::move(state.u);
  state.v_before = std::move(state.v);
  state.u = std::move(u_);
  state.v = std::move(v_);
  state.time = is_last ? end : state.time + report.length;
  ++state.steps;
  const double intervals = end / scene_.dt;
  report.completes = is_last && std::abs(intervals - std::round(intervals)) < 1e-6;
  history.in_interval = !report.completes;
  report.time = state.time;
}

FemStepReport StageFem::step(FemState& state, const std::function<bool()>& stop) {
  const Stopwatch watch;
  check_state(state, scene_.mesh.rest.rows());
  now_ = &state;
  control_ = state.stages.control;
  const bool is_auto = scene_.scheme == Scheme::kAuto;
  if (is_auto && !state.stages.in_interval) control_.begin_interval();
  const int64_t inner = solve_.iterations();
  terms_.freeze_rotations(state.u);
  motion_.begin(state);
  open_ledger();
  const double end = interval_end(), left = end - state.time;
  FemStepReport report;
  report.solves = 0;
  // trials, until one has an error that is accepted; the last resort is implicit Euler
  for (bool by_euler = false;;) {
    report.interrupted = stop();
    if (report.interrupted) return report;
    const int level = control_.level();
    const double h = is_auto ? control_.step(left, scene_.dt) : left;
    const bool made = make_step(by_euler ? TimeScheme::kEuler : kind_of(h), h, report);
    report.inner = int(solve_.iterations() - inner);
    if (made && (judge(report) || by_euler)) break;
    if (!made && meets_collider_) {
      control_.expect_impact();
      continue;
    }
    if (!made && (!is_auto || level == TimeControl::kMostLevel)) return report;
    // shorter steps may be finite; an error that was accepted leaves the energy to blame
    if (!made) control_.accepts(kNever);
    if (made) by_euler = report.time_ratio <= 1 || level == TimeControl::kMostLevel;
    ++report.rejected;
  }
  complete(end, state, report);
  report.ms = watch.milliseconds();
  return report;
}

}  // namespace elastogen::fem
