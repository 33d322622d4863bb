// SPDX-License-Identifier: Apache-2.0
// Estimate of what a step adds to the error of time integration, on each piece:
//
//     y   = a_1 e_1 + a_0 e_0 + a_b e_b,     that of the scheme, by differences of velocities,
//     est = 1.8 (rms(S y) + W rms(u)),       rms weighted with mass,
//     S   = (M/T^2 + K)^-1 M/T^2,            T the dt of the scene: drops what a frame cannot show,
//     u   = the rigid part of the same combination of contact forces over mass, a velocity,
//     W   = min(T, c/|g|), 0 where c^2 / (2 |g|) < 1 % of the size: bounces that low are let die,
//     c   the speed at which the piece met a collider, which fades by 0.8 in each T.
//
// The step is accepted where (T/h) est <= tolerance max(T v, 0.04 size), v the rms speed, in contact
// without spin. What is said of it has T in place of W where c, or the change of velocity of the piece
// while it touches, of late, is that of a bounce that counts: no steps are spent on the error of what
// the last of many small impacts bring, but it is no secret.

#pragma once

#include "core/ledger.hpp"

#include <algorithm>

namespace elastogen {

inline constexpr double kErrorSafety = 1.8;   ///< factor of the estimate
inline constexpr double kMotionFloor = 0.04;  ///< of the size that counts as motion in T
inline constexpr double kLowBounce = 0.01;    ///< height of bounces that are let die, of the size
inline constexpr double kClosingFades = 0.8;  ///< closing speed that is left after T
inline constexpr double kStrikeLasts = 2;     ///< in T: then 1/e of a change of velocity is left
inline constexpr double kSpeedRemembered = 0.9;  ///< speed that counts after T
inline constexpr double kClearRatio = 0.1;  ///< below it S, which lowers the estimate, is left out
/// S y is found by PCG to this residual, of the right-hand side, in so many iterations at most.
inline constexpr double kFilterTolerance = 0.05;
inline constexpr int kFilterIterations = 30;

/// Speed that counts as motion of a piece, of its rms speed without the spin of its rigid motion, and
/// the rms speed of that. A torque of contact turns the axis of a spin slowly, however fast that is.
inline double counted_speed(double speed, double spin, bool touches) {
  return touches ? speed : std::hypot(speed, spin);
}

/// Whether a bounce at a speed [m/s] is high enough to count for a piece of a size [m].
inline bool bounce_counts(double speed, double gravity, double interval, double size) {
  const double height = gravity > 0 ? speed * speed / (2 * gravity) : speed * interval;
  return height >= kLowBounce * size;
}

struct TimeErrorOptions {
  double interval = 0;       ///< T [s]
  double tolerance = 0.005;  ///< of the motion in T
};

struct TimeError {
  double estimate = 0;  ///< what is said of the piece where `ratio` is largest [m]
  double ratio = 0;     ///< of what counts to what is accepted
};

/// What the error u of a piece's velocity by contact adds to the two [m].
struct ContactError {
  double said = 0, counted = 0;
};

/// @param closing  c [m/s]
/// @param struck   change of velocity while the piece touches, of late [m/s].
/// @param u        rms [m/s].
inline ContactError contact_error(double closing, double struck, double gravity, double interval,
                                  double size, double u) {
  const bool counts = !(gravity > 0 && closing * closing / (2 * gravity) < kLowBounce * size);
  const double W = gravity > 0 ? std::min(interval, closing / gravity) : interval;
  ContactError error = {counts ? W * u : 0, counts ? W * u : 0};
  if (bounce_counts(std::max(closing, struck), gravity, interval, size))
    error.said = std::max(error.said, interval * u);
  return error;
}

/// The end of a step of stages.
struct StageEnd {
  bool keeps_energy = true;  ///< false: contact brought more than velocities can make good
  TimeError error;           ///< where it was asked for
  bool guarded = false;      ///< contact brought some, which was taken from the velocities
  StepLedger ledger;
};

/// Weights a_1, a_0, a_b of y [s].
struct StepWeights {
  double end = 0, start = 0, other = 0;
};

/// Weights of a step that ends with this stage.
inline StepWeights step_weights(const TimeStage& stage) {
  constexpr double s = kSdirkStage, kError = 0.0808;
  const double h = stage.t;
  if (stage.t_b > 0) return {kError * h / (1 - s), kError * h / s, -kError * h / (s * (1 - s))};
  if (stage.t_b == 0) return {h / 2, -h / 2, 0};
  const double before = -stage.t_b, r = h / before;
  const double scale = (1 + r) * (1 + r) / (6 * r * (1 + 2 * r)) * 2 * h * h * h / (h + before);
  return {scale / h, -scale / h - scale / before, scale / before};
}

}  // namespace elastogen
