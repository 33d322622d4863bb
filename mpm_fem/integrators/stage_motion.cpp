// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/stage_motion.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

constexpr double kDifference = 0.1;  // of k, over which a prescribed motion is differentiated

/// a x + b y, entry by entry.
Array<double> combination(double a, const Array<double>& x, double b, const Array<double>& y) {
  Array<double> result(x.rows(), 3);
  for (int64_t k = 0; k < x.size(); ++k) result.data()[k] = a * x.data()[k] + b * y.data()[k];
  return result;
}

}  // namespace

StageMotion::StageMotion(const FemScene& scene, const FemPieces& pieces)
    : scene_(scene), pieces_(pieces) {}

/// Turns of pieces with pins, and how they change.
void StageMotion::find_turns() {
  const StageHistory& history = state_->stages;
  turn_.assign(pieces_.count(), {});
  gain_.assign(pieces_.count(), 0);
  for (size_t p = 0; p < pieces_.count(); ++p) {
    if (!pieces_.is_pinned(p)) continue;
    turn_[p] = pieces_.turn_about_pins(p, now_[p]);
    const double rate = safe_norm(turn_[p]);
    if (!(rate > kStill) || history.pieces.empty() || !(history.h_before > 0)) continue;
    const Vec3 change = minus(turn_[p], history.pieces[p].turn);
    gain_[p] = dot(change, turn_[p]) / (rate * history.h_before);
  }
}

StageMotion::Reference StageMotion::reference_at(double t) const {
  // the pose of each piece
  std::vector<RigidPose> poses(pieces_.count());
  for (size_t p = 0; p < poses.size(); ++p) {
    if (pieces_.is_loose(p)) poses[p] = pose_at(pieces_.rigid_motion(p, now_[p]), t);
    if (pieces_.is_pinned(p)) poses[p] = turned_about(pieces_.pins(p), turn_[p], gain_[p], t);
  }
  // what it means for its nodes
  const Array<double>& rest = scene_.mesh.rest;
  Reference z{Array<double>(rest.rows(), 3), Array<double>(rest.rows(), 3),
              Array<double>(rest.rows(), 3)};
  for (int64_t n = 0; n < rest.rows(); ++n) {
    const size_t p = pieces_.of(n);
    if (!pieces_.is_loose(p) && !pieces_.is_pinned(p)) continue;
    const Vec3 x0 = plus(row_of(rest, n), row_of(state_->u, n));
    const Vec3 shift = reference_motion(poses[p], x0), velocity = reference_velocity(poses[p], x0),
               acceleration = reference_acceleration(poses[p], x0);
    std::copy(shift.begin(), shift.end(), z.shift.row(n));
    std::copy(velocity.begin(), velocity.end(), z.velocity.row(n));
    std::copy(acceleration.begin(), acceleration.end(), z.acceleration.row(n));
  }
  for (Array<double>* field : {&z.shift, &z.velocity, &z.acceleration})
    scene_.dependent.fill(field->data());
  return z;
}

void StageMotion::begin(const FemState& state) {
  state_ = &state;
  now_ = pieces_.motions(state.u, state.v);
  before_.clear();
  if (!state.u_before.empty()) before_ = pieces_.motions(state.u_before, state.v_before);
  find_turns();
  e_0_ = combination(1, state.v, -1, reference_at(0).velocity);
}

/// d and e at the other point of a stage of the first kind, the step before.
void StageMotion::set_other(double t_b) {
  const Reference z = reference_at(t_b);
  d_b_ = combination(1, combination(1, state_->u_before, -1, state_->u), -1, z.shift);
  e_b_ = combination(1, state_->v_before, -1, z.velocity);
}

void StageMotion::keep_stage(const Array<double>& u) {
  d_b_ = combination(1, combination(1, u, -1, state_->u), -1, end_.shift);
  e_b_ = combination(1 / stage_.k, d_b_, 0, d_b_);
}

void StageMotion::begin_stage(const TimeStage& stage) {
  stage_ = stage;
  if (stage.t_b == 0) d_b_ = e_b_ = Array<double>(e_0_.rows(), 3);
  if (stage.t_b < 0) set_other(stage.t_b);
  end_ = reference_at(stage.t);
  predictor_ = state_->u;
  for (int64_t k = 0; k < predictor_.size(); ++k) {
    const double pull = scene_.gravity[size_t(k % 3)] - end_.acceleration.data()[k];
    predictor_.data()[k] += end_.shift.data()[k] + stage.w_d * d_b_.data()[k] +
                            stage.w_e * e_b_.data()[k] + stage.w_0 * e_0_.data()[k] +
                            stage.k * stage.k * pull;
  }
  prescribe();
}

/// Velocities and predictors of prescribed components.
void StageMotion::prescribe() {
  given_velocity_ = Array<double>(predictor_.rows(), 3);
  if (scene_.fixed.empty()) return;
  const double time = state_->time + stage_.t, step = kDifference * stage_.k,
               kk = stage_.k * stage_.k;
  const Array<double> at = with_motion(scene_, time, predictor_);
  Array<double> early = at, late = at;
  if (scene_.motion) {
    early = with_motion(scene_, time - step, predictor_);
    late = with_motion(scene_, time + step, predictor_);
  }
  for (int64_t k = 0; k < predictor_.size(); ++k) {
    if (!is_fixed(k)) continue;
    const double before = early.data()[k], here = at.data()[k], after = late.data()[k];
    given_velocity_.data()[k] = (after - before) / (2 * step);
    const double acceleration = ((after - here) - (here - before)) / (step * step);
    predictor_.data()[k] = here + kk * (scene_.gravity[size_t(k % 3)] - acceleration);
  }
}

std::vector<Array<double>> StageMotion::starts() const {
  Array<double> steady = state_->u;
  for (int64_t k = 0; k < steady.size(); ++k)
    steady.data()[k] += end_.shift.data()[k] + stage_.t * e_0_.data()[k];
  return {combination(1, predictor_, stage_.k * stage_.k, end_.acceleration), std::move(steady)};
}

Array<double> StageMotion::velocities(const Array<double>& u) const {
  Array<double> v = given_velocity_;
  for (int64_t k = 0; k < v.size(); ++k) {
    if (is_fixed(k)) continue;
    const double d = u.data()[k] - state_->u.data()[k] - end_.shift.data()[k];
    v.data()[k] = end_.velocity.data()[k] + (d - stage_.w_v * d_b_.data()[k]) / stage_.k;
  }
  return v;
}

Array<double> StageMotion::relative(const Array<double>& v) const {
  Array<double> e = combination(1, v, -1, end_.velocity);
  for (int64_t k = 0; k < e.size(); ++k)
    if (is_fixed(k)) e.data()[k] = 0;
  scene_.dependent.fill(e.data());
  return e;
}

Array<double> StageMotion::combined(const StepWeights& weights, const Array<double>& v) const {
  Array<double> y = relative(v);
  for (int64_t k = 0; k < y.size(); ++k)
    y.data()[k] = is_fixed(k) ? 0
                              : weights.end * y.data()[k] + weights.start * e_0_.data()[k] +
                                    weights.other * e_b_.data()[k];
  scene_.dependent.fill(y.data());
  return y;
}

TwoMomenta StageMotion::gain_of_references(const Vec3& about, const Array<double>& mass) const {
  TwoMomenta gain;
  if (std::none_of(turn_.begin(), turn_.end(), [](const Vec3& w) { return safe_norm(w) > 0; }))
    return gain;
  // m times a vector of the reference, and its moment
  const auto add = [&](const Reference& z, const Array<double>& of, double weight) {
    for (int64_t n = 0; n < of.rows(); ++n) {
      const size_t p = pieces_.of(n);
      if (!pieces_.is_pinned(p)) continue;
      Vec3 value = scaled(row_of(of, n), weight * mass(n));
      for (int d = 0; d < 3; ++d)
        if (is_fixed(3 * n + d)) value[size_t(d)] = 0;
      const Vec3 place =
          plus(plus(row_of(scene_.mesh.rest, n), row_of(state_->u, n)), row_of(z.shift, n));
      gain.add({value, cross(minus(place, about), value)}, 1);
    }
  };
  // from the start to the end, without what the stages integrate
  const TimeStage& s = stage_;
  const Reference start = reference_at(0);
  add(end_, end_.velocity, 1);
  add(end_, end_.acceleration, -s.k);
  add(start, start.velocity, s.t_b < 0 ? s.w_d - 1 : -1);
  if (s.t_b == 0) return gain;
  const Reference other = reference_at(s.t_b);
  if (s.t_b < 0) add(other, other.velocity, -s.w_d);
  if (s.t_b > 0) add(other, other.acceleration, s.k - s.t);
  return gain;
}

}  // namespace elastogen::fem
