// SPDX-License-Identifier: Apache-2.0
// The time error of a step of stages (core/time_error.hpp).
#include "mpm_fem/integrators/stage_fem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen::fem {
namespace {

constexpr double kLooseFilter = 1e-2;  // residual of the filter's linear system

/// What is left of an rms speed without that of the spin.
double without(double speed, double spin) {
  return std::sqrt(std::max(speed * speed - spin * spin, 0.0));
}

}  // namespace

/// rms speed of the spin of a loose piece [m/s].
double StageFem::spin_speed(size_t p, const PieceMotion& motion) const {
  if (!pieces_.is_loose(p)) return 0;
  const RigidMotion rigid = pieces_.rigid_motion(p, motion);
  const Vec3 w = times(rigid.per_inertia, rigid.spin);
  return std::sqrt(std::max(0.0, dot(w, rigid.spin)) / pieces_.mass(p));
}

/// Speeds of the pieces, and at which they met colliders.
/// @param share  of dt that the step takes
void StageFem::remember_speeds(double share) {
  const std::vector<double> start = pieces_.rms(now_->v), end = pieces_.rms(v_);
  const std::vector<PieceMotion> first = pieces_.motions(now_->u, now_->v);
  memory_ = now_->stages.pieces;
  memory_.resize(pieces_.count());
  for (size_t p = 0; p < memory_.size(); ++p) {
    PieceMemory& piece = memory_[p];
    const double turn[2] = {spin_speed(p, first[p]), spin_speed(p, end_[p])};
    piece.speed = std::max({without(start[p], turn[0]), without(end[p], turn[1]),
                            std::pow(kSpeedRemembered, share) * piece.speed});
    piece.spin = std::max(turn[0], turn[1]);
    piece.closing *= std::pow(kClosingFades, share);
    for (const Loads* loads : {&at_stage_, &at_end_})
      if (!loads->pieces.empty() && loads->pieces[p].push > 0)
        piece.closing = std::max(piece.closing, loads->pieces[p].closing);
    piece.struck = scaled(piece.struck, std::exp(-share / kStrikeLasts));
    if (touched(p)) piece.struck = plus(piece.struck, minus(end_[p].velocity, first[p].velocity));
    piece.turn = motion_.turns()[p];
  }
}

/// The least motion that counts in dt, of all pieces, before the step [m].
double StageFem::least_motion() const {
  const std::vector<double> rms = pieces_.rms(now_->v);
  const std::vector<PieceMemory>& memory = now_->stages.pieces;
  double least = std::numeric_limits<double>::infinity();
  for (size_t p = 0; p < rms.size(); ++p) {
    const PieceMemory of = memory.empty() ? PieceMemory{} : memory[p];
    const Loads& now = now_->stages.now;
    const bool touches = !now.pieces.empty() && now.pieces[p].push > 0;
    const double speed =
        counted_speed(std::max(without(rms[p], of.spin), of.speed), of.spin, touches);
    least = std::min(least, std::max(scene_.dt * speed, kMotionFloor * pieces_.size(p)));
  }
  return least;
}

ContactError StageFem::contact_error_of(size_t p, const StepWeights& weights) const {
  if (!pieces_.is_loose(p) || !touched()) return {};
  // the combination of impulses, and the rigid motion that it gives the piece
  Load impulse;
  const auto add = [&](const Loads& loads, double weight) {
    if (loads.pieces.empty()) return;
    const Load& contact = loads.pieces[p].contact;
    impulse.force = plus(impulse.force, scaled(contact.force, weight));
    impulse.torque = plus(impulse.torque, scaled(contact.torque, weight));
  };
  add(at_end_, weights.end);
  add(now_->stages.now, weights.start);
  add(motion_.stage().t_b > 0 ? at_stage_ : now_->stages.before, weights.other);
  const RigidMotion given =
      pieces_.rigid_motion(p, {end_[p].centre, impulse.force, impulse.torque, end_[p].inertia});
  const Vec3 turn = times(given.per_inertia, given.spin);
  const double m = pieces_.mass(p),
               square = dot(given.velocity, given.velocity) / (m * m) + dot(turn, given.spin) / m;
  return contact_error(memory_[p].closing, safe_norm(memory_[p].struck), safe_norm(scene_.gravity),
                       scene_.dt, pieces_.size(p), std::sqrt(std::max(0.0, square)));
}

/// The estimate of the piece where it is largest in relation to what is accepted.
TimeError StageFem::worst(const Array<double>& y, const StepWeights& weights) const {
  const std::vector<double> rms = pieces_.rms(y);
  const double share = motion_.stage().t / scene_.dt;
  TimeError result;
  for (size_t p = 0; p < rms.size(); ++p) {
    const ContactError contact = contact_error_of(p, weights);
    const double estimate = kErrorSafety * (rms[p] + contact.counted);
    const double speed = counted_speed(memory_[p].speed, memory_[p].spin, touched(p));
    const double motion = std::max(scene_.dt * speed, kMotionFloor * pieces_.size(p));
    const double ratio = estimate / (share * options_.time_error * motion);
    if (!(ratio <= result.ratio)) result = {kErrorSafety * (rms[p] + contact.said), ratio};
  }
  return result;
}

/// S y at the end of the step, by a Newton step of implicit Euler over dt from y. Where the
/// Hessian cannot be factored y itself, which is larger.
Array<double> StageFem::filtered(const Array<double>& y) {
  const double per_square = 1 / (scene_.dt * scene_.dt);
  potential_.set_inertia(per_square, u_);
  if (terms_.viscous) terms_.viscous->body().set_rate(1 / scene_.dt);
  Array<double> pull(y.rows(), 3), result(y.rows(), 3);
  potential_.mass().multiply(y.data(), pull.data());
  for (int64_t k = 0; k < pull.size(); ++k) pull.data()[k] *= -per_square;
  potential_.constraint().fold(pull.data());
  const bool found = potential_.newton_step(u_.data(), pull.data(), TangentKind::kProjected,
                                            kLooseFilter, nullptr, result.data());
  return found ? result : y;
}

/// What the step adds to the time error. The filter, which lowers it, is left out where it is small
/// anyway.
TimeError StageFem::error() {
  const StepWeights weights = step_weights(motion_.stage());
  const Array<double> y = motion_.combined(weights, v_);
  const TimeError rough = worst(y, weights);
  if (rough.ratio < kClearRatio || !std::isfinite(rough.ratio)) return rough;
  return worst(filtered(y), weights);
}

}  // namespace elastogen::fem
