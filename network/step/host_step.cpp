// SPDX-License-Identifier: Apache-2.0
#include "network/step/host_step.hpp"

#include "core/pcg.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

HostStep::HostStep(PotentialTerms&& terms, const EncoderChoice* encoder, const PaperLoops& loops,
                   bool in_float)
    : scene_(terms.scene()),
      potential_(std::move(terms)),
      predictor_(scene_),
      flight_(scene_),
      u_(3 * size_t(scene_.grid.node_count())),
      gradient_(u_.size()) {
  if (has_stages(scene_.scheme)) {
    stage_machine_.emplace(potential_);
    stages_.emplace(*stage_machine_);
    v_ = Array<double>(scene_.grid.node_count(), 3);
  }
  if (!encoder)
    paper_.emplace(potential_, loops);
  else if (in_float)
    single_.emplace(potential_, *encoder);
  else
    precise_.emplace(potential_, *encoder);
}

void HostStep::upload(const State& state) {
  own_ = state, state_ = &own_;
  forget();
}

/// Of another state nothing is known but itself.
void HostStep::forget() {
  if (!stages_) return;
  stages_->forget();
  potential_.contact().forget_bonds();
}

void HostStep::borrow(State& state) {
  state_ = &state;
  if (stages_ && !stages_->knows(state.time)) forget();
}

void HostStep::download(State& state, StateParts parts) {
  if (parts == StateParts::kAll)
    state = *state_;
  else
    state.x = state_->x;
}

double HostStep::reach() {
  double largest = 0;
  for (int64_t k = 0; k < state_->x.size(); ++k)
    largest = std::max(largest, std::abs(state_->x.data()[k]));
  return largest;
}

/// Phi in float64.
double HostStep::phi_at(const Zeroed<double>& u) {
  return potential_.evaluate<double>(u.data(), gradient_.data()).total();
}

/// u_now with held nodes where they are at the end of the step.
const Zeroed<double>& HostStep::now_held() {
  if (!potential_.held().move()) return potential_.now();
  now_held_ = potential_.now();
  potential_.held().place(now_held_.data());
  return now_held_;
}

/// Phi in float where that has the digits, to find where iterations begin.
double HostStep::rough_phi(const Zeroed<double>& u) {
  if (precise_) return phi_at(u);
  return potential_.evaluate(u.data(), static_cast<float*>(nullptr)).total();
}

void HostStep::begin_step(const StepScheme& scheme, double time) {
  scheme_ = scheme;
  state_->time = time;
  potential_.begin_loads(*state_, scheme, !scheme.is_stage || scheme.stage.t_b <= 0);
  if (scheme.is_stage) return begin_stage();
  potential_.begin_step(*state_, scheme);
  if (paper_) return;
  predictor_.start(*state_, potential_.predictor(), u_.data());
  potential_.held().place(u_.data());
}

void HostStep::begin_stage() {
  const double* motion = stages_.value().begin(
      {state_->x.data(), state_->v.data(), state_->x_before.data(), state_->v_before.data()},
      scheme_);
  if (stages_->has_no_ledger()) open_ledger(motion);
  // u_ is still that of the first stage where this is the second one
  const double* stage_before = scheme_.stage.t_b > 0 ? u_.data() : nullptr;
  potential_.begin_stage(*state_, scheme_, motion, stage_before);
  precise_ ? precise_->update_inertia() : single_.value().update_inertia();
  stages_->start(0, u_.data());
}

/// Opens the ledger of steps with the energies at the start, those of a step of no length.
void HostStep::open_ledger(const double* motion) {
  const StepScheme at_once(TimeScheme::kEuler, euler_stage(kNoTime * scene_.dt));
  potential_.begin_stage(*state_, at_once, motion, nullptr);
  const PotentialValue value =
      potential_.evaluate(potential_.now().data(), static_cast<double*>(nullptr));
  stages_->open_ledger(potential_.now().data(), value.elastic + value.hourglass);
}

void HostStep::evaluate_starts(int count, double* phi) {
  phi[0] = rough_phi(u_);
  starts_.clear();
  for (int order = 1; order < count; ++order) {
    Zeroed<double>& start = starts_.emplace_back(u_);
    scheme_.is_stage ? stages_.value().start(order, start.data())
                     : predictor_.extrapolate(*state_, scheme_, order, start.data());
    potential_.held().place(start.data());
    phi[order] = rough_phi(start);
  }
}

void HostStep::use_start(int start) {
  if (start > 0) u_.swap(starts_[size_t(start - 1)]);
}

double HostStep::farthest() {
  const Zeroed<double>& now = potential_.now();
  double farthest = 0;
  for (size_t k = 0; k < u_.size(); ++k) farthest = std::max(farthest, std::abs(u_[k] - now[k]));
  return farthest;
}

const Collider* HostStep::clear_start() {
  clear_ = potential_.now();
  potential_.held().place(clear_.data());
  Contact& contact = potential_.contact();
  is_cut_ = false;
  if (!contact.exists()) return nullptr;
  contact.carry(clear_.data());
  potential_.held().follow(clear_.data());
  if (const Collider* inside = contact.obstacle(clear_.data())) return inside;
  const double share = contact.longest_step(clear_.data(), u_.data());
  is_cut_ = share < 1;
  if (is_cut_)
    for (size_t k = 0; k < u_.size(); ++k) u_[k] = clear_[k] + share * (u_[k] - clear_[k]);
  return nullptr;
}

template <class T, class P>
IterationResult HostStep::quasi(std::unique_ptr<QuasiSolver<T>>& solver, double target,
                                int max_outer, Preconditioner<P>& first,
                                const Interrupted& interrupted) {
  if (!solver) solver = std::make_unique<QuasiSolver<T>>(potential_);
  return solver->solve(u_.data(), target, max_outer, first, interrupted);
}

IterationResult HostStep::quasi(double target, int max_outer, double precise_below,
                                const Interrupted& interrupted) {
  if (precise_) return quasi(quasi_double_, target, max_outer, *precise_, interrupted);
  if (precise_below <= target) return quasi(quasi_float_, target, max_outer, *single_, interrupted);
  return quasi(quasi_double_, target, max_outer, *single_, interrupted);
}

IterationResult HostStep::newton(double target, int max_outer, int max_inner,
                                 const Interrupted& interrupted) {
  if (!newton_) newton_ = std::make_unique<NewtonSolver>(potential_);
  const auto solve = [&](auto& first) {
    return newton_->solve(u_.data(), target, max_outer, max_inner, first, interrupted);
  };
  return precise_ ? solve(*precise_) : solve(*single_);
}

/// Whether something feels a collider at u.
bool HostStep::touches() {
  return potential_.contact().evaluate(u_.data(), static_cast<double*>(nullptr)) != 0;
}

/// Gives pieces in free flight the mean motion of their predictor, which iterations know to the
/// tolerance only, unless something touches before or after. Says whether they got it.
bool HostStep::balance() {
  if (!flight_.exists() || paper_ || touches()) return false;
  u_before_shift_ = u_;
  const Zeroed<double>& aim = potential_.predictor();
  flight_.match_means(u_.data(), [&](size_t n, size_t d) { return aim[3 * n + d]; });
  if (!touches()) return true;
  u_.swap(u_before_shift_);
  return false;
}

/// x_next = X + u on the nodes that move, the present x on the others; u = x_next - X.
void HostStep::round_positions() {
  const Array<double>& X = scene_.grid.rest;
  x_ = state_->x;
  const auto round = [&](NodeKind kind, bool moves) {
    for_each(X.rows(), [&](int64_t n) {
      if (scene_.pinned(n) != kind) return;
      for (int d = 0; d < 3; ++d) {
        if (moves) x_(n, d) = X(n, d) + u_[size_t(3 * n + d)];
        u_[size_t(3 * n + d)] = x_(n, d) - X(n, d);
      }
    });
  };
  round(kFreeNode, true);
  round(kPinnedNode, potential_.held().move());
  if (scene_.dependent.empty()) return;
  potential_.held().follow(u_.data());
  round(kDependentNode, true);
}

Certificate HostStep::certify() {
  in_flight_ = balance();
  round_positions();
  Certificate result{potential_.residual(u_.data(), gradient_.data())};
  result.reactions = potential_.reactions();
  certificate_ = {result.value.elastic + result.value.hourglass,
                  damping_power(result.value, scheme_), potential_.held().power(result.reactions),
                  gradient_.data()};
  result.size = norm(gradient_.data(), int64_t(gradient_.size()));
  result.finite = std::isfinite(result.value.total()) && std::isfinite(result.size) &&
                  all_finite(u_.data(), int64_t(u_.size()));
  return result;
}

/// Takes from v what the rounding of positions brings into its mean.
void HostStep::conserve_momentum(Array<double>& v) {
  const Array<double>& before = state_->v_before.empty() ? state_->v : state_->v_before;
  flight_.match_means(v.data(), [&](size_t n, size_t d) {
    const auto node = int64_t(n);
    return free_velocity(scheme_, state_->v(node, int64_t(d)), before(node, int64_t(d)),
                         potential_.loads().pull(node, int(d)));
  });
}

/// Of the free nodes, of those that follow them, and of pinned ones that move.
Array<double> HostStep::next_velocities() const {
  const Array<double>& x_before = state_->x_before.empty() ? state_->x : state_->x_before;
  Array<double> v(x_.rows(), 3);
  for_each(x_.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d)
      if (scene_.pinned(n) != kPinnedNode)
        v(n, d) = velocity_after(scheme_, x_(n, d), state_->x(n, d), x_before(n, d));
  });
  potential_.held().set_velocities(x_.data(), v.data());
  return v;
}

/// y = S y, S of time_error.hpp, by PCG.
template <class P>
void HostStep::filter(Preconditioner<P>& first, double interval, double* y) {
  const auto size = int64_t(u_.size());
  potential_.set_scheme({TimeScheme::kEuler, interval, 1});
  potential_.linearise(u_.data());
  first.update_inertia();
  first.update_contact();
  std::vector<float> right(u_.size()), solution(u_.size());
  // scaled to 1, so that float holds it
  double most =
      largest(size, [&](int64_t k) { return std::abs(potential_.inertia(k / 3) * y[k]); });
  if (most == 0) most = 1;
  for_each(size,
           [&](int64_t k) { right[size_t(k)] = float(potential_.inertia(k / 3) * y[k] / most); });
  potential_.held().fold(right.data());
  PcgWork<float> work(size);
  pcg(
      right.data(), solution.data(), size, kFilterTolerance, kFilterIterations, work,
      [&](const float* p, float* Ap) { potential_.hessian_product(p, Ap); },
      [&](const float* r, float* z) { first.apply(r, z); });
  for_each(size, [&](int64_t k) { y[k] = most * double(solution[size_t(k)]); });
}

void HostStep::filter(double interval, double* y) {
  precise_ ? filter(*precise_, interval, y) : filter(*single_, interval, y);
}

bool HostStep::renew_lags() {
  Contact& contact = potential_.contact();
  const bool rubs = scheme_.is_stage && contact.exists() && contact.renew_lag(u_.data());
  if (!potential_.loads().blows()) return rubs;
  if (scheme_.is_stage)
    stages_.value().velocities(x_.data(), v_.data());
  else
    v_ = next_velocities();
  potential_.take_wind(x_.data(), v_.data());
  return true;
}

void HostStep::keep_stage() {
  stages_.value().keep_stage(u_.data(), certificate_);
  if (has_changing_loads(scene_)) first_load_ = potential_.loads().all();
}

StageData HostStep::stage_data() {
  StageData data;
  if (has_changing_loads(scene_))
    data.load = potential_.loads().all(), data.first_load = first_load_;
  if (!stages_) return data;
  data.first = {stage_machine_->first_stage(), scene_.grid.node_count(), 3};
  data.bonds = potential_.contact().bonds();
  return data;
}

StageEnd HostStep::end_step(const TimeErrorOptions* options) {
  StageEnd end;
  end.keeps_energy = stages_.value().end_step(x_.data(), u_.data(), certificate_, v_.data());
  end.guarded = stages_->guarded();
  end.ledger = stages_->ledger();
  if (options)
    end.error =
        stages_->error(v_.data(), *options, [&](double* y) { filter(options->interval, y); });
  return end;
}

MotionEnergy HostStep::finish() {
  Array<double> v = scheme_.is_stage ? v_ : next_velocities();
  if (scheme_.is_stage) {
    stages_->accept(state_->time + scheme_.end());
    potential_.contact().keep_bonds(u_.data());
    state_->h_before = scheme_.end();
  } else if (in_flight_) {
    conserve_momentum(v);
  }
  MotionEnergy energy;
  for (int64_t n = 0; n < x_.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      if (scene_.pinned(n) != kPinnedNode)  // the others go with what holds them
        energy.kinetic += scene_.mass(n) / 2 * v(n, d) * v(n, d);
      energy.gravity -= scene_.mass(n) * scene_.gravity[size_t(d)] * x_(n, d);
    }
  state_->x_before = std::move(state_->x);
  state_->v_before = std::move(state_->v);
  state_->x = std::move(x_);
  state_->v = std::move(v);
  return energy;
}

std::unique_ptr<StepWork> make_host_step(PotentialTerms&& terms, const EncoderChoice* encoder,
                                         const PaperLoops& loops, bool in_float) {
  return std::make_unique<HostStep>(std::move(terms), encoder, loops, in_float);
}

}  // namespace elastogen
