// SPDX-License-Identifier: Apache-2.0
// When a step along a descent direction is accepted.

#pragma once

namespace elastogen {

/// Armijo's rule Phi(1) - Phi(0) <= 1e-4 Phi'(0), with slopes taken along the whole step. Where the
/// difference drowns in the noise of Phi the mean slope (Phi'(0) + Phi'(1))/2, which is the same
/// difference to second order, decides instead (Hager, Zhang 2005).
inline bool sufficient_decrease(double difference, double slope_start, double slope_end,
                                double noise) {
  constexpr double kShare = 1e-4;
  if (difference <= kShare * slope_start) return true;
  return difference <= noise && (slope_start + slope_end) / 2 <= kShare * slope_start;
}

/// What Phi has changed by: the difference of its values, or its mean slope where they drown.
inline double difference_or_mean(double difference, double slope_start, double slope_end,
                                 double noise) {
  const bool drowns = -noise <= difference && difference <= noise;
  return drowns ? (slope_start + slope_end) / 2 : difference;
}

}  // namespace elastogen
