// SPDX-License-Identifier: Apache-2.0
// The estimate of time_error.hpp, and the scale of motion it is held against.
#include "network/step/stages.hpp"

#include <algorithm>

namespace elastogen {
/// Speeds of the pieces, and at which they met colliders. share: of T that the step takes.
void Stages::note_speeds(const double* v, double share) {
  const std::vector<PieceSums> squares = machine_.sum(Products{at_, at_.state.v, v});
  speed_next_.resize(pieces_.count());
  spin_next_.resize(pieces_.count());
  closing_next_.resize(pieces_.count());
  struck_next_.resize(pieces_.count());
  for (size_t p = 0; p < pieces_.count(); ++p) {
    // at the start and at the end
    const double m = pieces_.mass(p), whole[2] = {squares[p][0] / m, squares[p][2] / m};
    const bool loose = pieces_.is_loose(p);
    const double turn[2] = {loose ? pieces_.spin_square(p, now_[p]) / m : 0,
                            loose ? pieces_.spin_square(p, last_[p]) / m : 0};
    const double rest = std::max({whole[0] - turn[0], whole[1] - turn[1], 0.0});
    speed_next_[p] = std::max(std::sqrt(rest), std::pow(kSpeedRemembered, share) * speed_[p]);
    spin_next_[p] = std::sqrt(std::max(turn[0], turn[1]));
    closing_next_[p] = std::pow(kClosingFades, share) * closing_[p];
    for (const Forces* f : {&at_stage_, &at_end_})
      if (!f->pieces.empty() && f->pieces[p].normal > 0)
        closing_next_[p] =
            std::max(closing_next_[p], std::abs(f->pieces[p].power) / f->pieces[p].normal);
    struck_next_[p] = scaled(struck_[p], std::exp(-share / kStrikeLasts));
    if (touched(p))
      struck_next_[p] = plus(struck_next_[p], minus(last_[p].velocity, now_[p].velocity));
  }
}

double Stages::least_motion(const double* v, double interval) {
  double least = 1e300;
  const std::vector<PieceSums> squares = machine_.sum(Products{at_, v, v});
  for (size_t p = 0; p < pieces_.count(); ++p) {
    const double whole = squares[p][0] / pieces_.mass(p), spin = spin_[p];
    const bool touches = !at_start_.pieces.empty() && at_start_.pieces[p].normal > 0;
    const double rest = std::sqrt(std::max(whole - spin * spin, 0.0));
    const double speed = counted_speed(std::max(rest, speed_[p]), spin, touches);
    least = std::min(least, std::max(interval * speed, kMotionFloor * pieces_.size(p)));
  }
  return least;
}

ContactError Stages::contact_error_of(size_t p, const StepWeights& weights,
                                      const TimeErrorOptions& options) const {
  if (!pieces_.is_loose(p) || !touched()) return {};
  // the impulse of the combination, and the rigid motion that it gives the piece
  Vec3 force = {}, torque = {};
  const auto add = [&](const Forces& f, double weight) {
    if (f.pieces.empty()) return;
    force = plus(force, scaled(f.pieces[p].force, weight));
    torque = plus(torque, scaled(f.pieces[p].torque, weight));
  };
  add(at_end_, weights.end);
  add(at_start_, weights.start);
  add(at_.stage.t_b > 0 ? at_stage_ : at_before_, weights.other);
  force = pieces_.slide(p, force);
  const Vec3 turn = times(pieces_.rigid_motion(p, last_[p]).per_inertia, torque);
  const double square =
      dot(force, force) / std::pow(pieces_.mass(p), 2) + dot(turn, torque) / pieces_.mass(p);
  return contact_error(closing_next_[p], safe_norm(struck_next_[p]), safe_norm(scene_.gravity),
                       options.interval, pieces_.size(p), std::sqrt(std::max(0.0, square)));
}

/// Of the piece where it is worst, by what is in the field.
TimeError Stages::worst_error(const StepWeights& weights, const TimeErrorOptions& options) {
  const double share = at_.stage.t / options.interval;
  const std::vector<PieceSums> squares =
      machine_.sum(Products{at_, machine_.field(), machine_.field()});
  TimeError worst;
  for (size_t p = 0; p < pieces_.count(); ++p) {
    const double rms = std::sqrt(squares[p][0] / pieces_.mass(p));
    const ContactError contact = contact_error_of(p, weights, options);
    const double estimate = kErrorSafety * (rms + contact.counted);
    const double speed = counted_speed(speed_next_[p], spin_next_[p], touched(p));
    const double motion = std::max(options.interval * speed, kMotionFloor * pieces_.size(p));
    const double ratio = estimate / (share * options.tolerance * motion);
    if (!(ratio <= worst.ratio)) worst = {kErrorSafety * (rms + contact.said), ratio};
  }
  return worst;
}

TimeError Stages::error(const double* v, const TimeErrorOptions& options, const Filter& filter) {
  const StepWeights weights = step_weights(at_.stage);
  note_speeds(v, at_.stage.t / options.interval);
  // y, and by S y where y itself is not small enough
  machine_.run(CombineVelocities{at_, weights, v, machine_.field()});
  const TimeError rough = worst_error(weights, options);
  if (rough.ratio < kClearRatio || !std::isfinite(rough.ratio)) return rough;
  filter(machine_.field());
  return worst_error(weights, options);
}

}  // namespace elastogen
