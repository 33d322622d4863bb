// SPDX-License-Identifier: Apache-2.0
// Stages of a time step whose motion is taken relative to a rigid reference z(t) (rigid_motion.hpp):
// implicit Euler, BDF2 of variable step, and the two stages of SDIRK2 (Alexander 1977).

#pragma once

#include "core/base.hpp"

#include <cmath>

namespace elastogen {

/// A stage at time t after the start of the step, with d = x - z, e = v - z'. It uses e_0 of the
/// start, where d_0 = 0, and d_b, e_b of one point more: for BDF2 the step before, for the second
/// stage of SDIRK2 the first one.
///
///     Phi  = m |x - xhat|^2 / (2 k^2) + E(x),
///     xhat = z(t) + w_d d_b + w_e e_b + w_0 e_0 + k^2 (g - z''(t)),
///     e    = (x - z(t) - w_v d_b) / k.
struct TimeStage {
  double t = 0, k = 0;  ///< [s]
  double t_b = 0;       ///< time of the other point [s], < 0: before the step; 0: there is none
  double w_d = 0, w_v = 0;
  double w_e = 0, w_0 = 0;  ///< [s]
};

/// s of SDIRK2, with which it is L-stable.
inline constexpr double kSdirkStage = 0.29289321881345247560;  // 1 - 1/sqrt(2)

/// Implicit Euler. Order 1.
inline TimeStage euler_stage(double h) {
  return {.t = h, .k = h, .w_0 = h};
}

/// BDF2 after a step of length h_before. Order 2; stable for h / h_before <= 2.4.
inline TimeStage bdf2_stage(double h, double h_before) {
  const double r = h / h_before, share = 1 / (1 + 2 * r), k = (1 + r) * share * h;
  const double before = -r * r * share;
  return {.t = h,
          .k = k,
          .t_b = -h_before,
          .w_d = before,
          .w_v = before,
          .w_e = k * before,
          .w_0 = k * (1 - before)};
}

/// A stage of SDIRK2: number 0 at s h, number 1 at h. With e_a = d_a / k and the relative
/// acceleration A_a = (e_a - e_0) / k of the first one the second is
///
///     xhat = z(h) + (1 - s) h e_a + k (e_0 + (1 - s) h A_a) + k^2 (g - z''(h)).
inline TimeStage sdirk2_stage(int number, double h) {
  const double k = kSdirkStage * h, rest = h - k;
  if (number == 0) return {.t = k, .k = k, .w_0 = k};
  return {.t = h, .k = k, .t_b = k, .w_d = 2 * rest / k, .w_v = rest / k, .w_0 = k - rest};
}

}  // namespace elastogen
