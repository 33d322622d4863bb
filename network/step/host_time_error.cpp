// SPDX-License-Identifier: Apache-2.0
// The estimate of core/time_error.hpp on the host, and the scale of motion it is held against.
#include "network/step/host_stages.hpp"

#include <algorithm>

namespace elastogen {
/// Speeds of the pieces, and at which they met colliders. share: of T that the step takes.
void HostStages::note_speeds(const Array<double>& v, double share) {
  speed_next_.resize(pieces_.count());
  closing_next_.resize(pieces_.count());
  for (size_t p = 0; p < pieces_.count(); ++p) {
    const auto squares = pieces_.sum<2>(p, [&](int64_t n, auto& sum) {
      sum[0] += scene_.mass(n) * dot(v0(n), v0(n));
      sum[1] += scene_.mass(n) * dot(vector(v, n), vector(v, n));
    });
    const double fastest = std::sqrt(std::max(squares[0], squares[1]) / pieces_.mass(p));
    speed_next_[p] = std::max(fastest, std::pow(kSpeedRemembered, share) * speed_[p]);
    closing_next_[p] = std::pow(kClosingFades, share) * closing_[p];
    for (const Forces* f : {&at_stage_, &at_end_})
      if (!f->pieces.empty() && f->pieces[p].normal > 0)
        closing_next_[p] =
            std::max(closing_next_[p], std::abs(f->pieces[p].power) / f->pieces[p].normal);
  }
}

double HostStages::least_motion(const State& state, double interval) const {
  double least = 1e300;
  for (size_t p = 0; p < pieces_.count(); ++p) {
    const double square = pieces_.sum<1>(p, [&](int64_t n, auto& sum) {
      const Vec3 v = vector(state.v, n);
      sum[0] += scene_.mass(n) * dot(v, v);
    })[0];
    const double speed = std::max(std::sqrt(square / pieces_.mass(p)), speed_[p]);
    least = std::min(least, std::max(interval * speed, kMotionFloor * pieces_.size(p)));
  }
  return least;
}

/// W rms(u) of a piece [m].
double HostStages::contact_error(size_t p, const StepWeights& weights,
                                 const TimeErrorOptions& options) {
  if (!pieces_.is_free(p) || !touched()) return 0;
  const double g = safe_norm(scene_.gravity), closing = closing_next_[p];
  if (g > 0 && closing * closing / (2 * g) < kLowBounce * pieces_.size(p)) return 0;
  const double W = g > 0 ? std::min(options.interval, closing / g) : options.interval;
  // the impulse of the combination, and the rigid motion that it gives the piece
  Vec3 force = {}, torque = {};
  const auto add = [&](const Forces& f, double weight) {
    if (f.pieces.empty()) return;
    force = plus(force, scaled(f.pieces[p].force, weight));
    torque = plus(torque, scaled(f.pieces[p].torque, weight));
  };
  add(at_end_, weights.end);
  add(at_start_, weights.start);
  add(scheme_.stage.t_b > 0 ? at_stage_ : at_before_, weights.other);
  const Vec3 turn = times(rigid_motion(last_[p]).per_inertia, torque);
  const double square =
      dot(force, force) / std::pow(pieces_.mass(p), 2) + dot(turn, torque) / pieces_.mass(p);
  return W * std::sqrt(std::max(0.0, square));
}

TimeError HostStages::error(const Array<double>& v, const TimeErrorOptions& options,
                            const Filter& filter) {
  const StepWeights weights = step_weights(scheme_.stage);
  const double share = scheme_.stage.t / options.interval;
  note_speeds(v, share);
  // y, then the worst piece by y itself and, where that does not suffice, by S y
  y_.resize(size_t(v.size()));
  for_each(v.rows(), [&](int64_t n) {
    Vec3 y = {};
    if (!scene_.pinned(n)) {
      y = plus(scaled(e1(n, v), weights.end), scaled(e0(n), weights.start));
      if (weights.other != 0) y = plus(y, scaled(e_b(n), weights.other));
    }
    for (size_t d = 0; d < 3; ++d) y_[3 * size_t(n) + d] = y[d];
  });

  const auto of = [&](const Zeroed<double>& field) {
    TimeError worst;
    for (size_t p = 0; p < pieces_.count(); ++p) {
      const double square = pieces_.sum<1>(p, [&](int64_t n, auto& sum) {
        for (size_t d = 0; d < 3; ++d)
          sum[0] += scene_.mass(n) * field[3 * size_t(n) + d] * field[3 * size_t(n) + d];
      })[0];
      const double estimate =
          kErrorSafety * (std::sqrt(square / pieces_.mass(p)) + contact_error(p, weights, options));
      const double motion =
          std::max(options.interval * speed_next_[p], kMotionFloor * pieces_.size(p));
      const double ratio = estimate / (share * options.tolerance * motion);
      if (!(ratio <= worst.ratio)) worst = {estimate, ratio};
    }
    return worst;
  };
  const TimeError rough = of(y_);
  if (rough.ratio < kClearRatio || !std::isfinite(rough.ratio)) return rough;
  filtered_.resize(y_.size());
  filter(y_.data(), filtered_.data());
  return of(filtered_);
}

}  // namespace elastogen
