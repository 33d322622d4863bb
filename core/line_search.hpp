// SPDX-License-Identifier: Apache-2.0
// Steps along a descent direction: when one is accepted, and how it is shortened until it is.
//
// Phi is the function that has to fall, in the share of the step. Slopes are its derivatives in
// that share.

#pragma once

#include <cmath>
#include <optional>

namespace elastogen {

/// Armijo's rule Phi(1) - Phi(0) <= 1e-4 Phi'(0), with slopes along the whole step. Where the
/// difference is within the noise of Phi, the mean slope (Phi'(0) + Phi'(1))/2, which equals it to
/// second order, decides instead (Hager, Zhang 2005).
inline bool sufficient_decrease(double difference, double slope_start, double slope_end,
                                double noise) {
  constexpr double kShare = 1e-4;
  if (difference <= kShare * slope_start) return true;
  return difference <= noise && (slope_start + slope_end) / 2 <= kShare * slope_start;
}

/// Change of Phi: the difference of its values or, where that is within the noise, its mean slope.
inline double difference_or_mean(double difference, double slope_start, double slope_end,
                                 double noise) {
  const bool drowns = -noise <= difference && difference <= noise;
  return drowns ? (slope_start + slope_end) / 2 : difference;
}

/// Values at a share of a step.
struct LineTrial {
  double share = 1;        ///< of the step
  double difference = 0;   ///< Phi(share) - Phi(0)
  double slope_start = 0;  ///< Phi'(0), of the whole step
  double slope_end = 0;    ///< share Phi'(share)
  double noise = 0;        ///< bound on the rounding error of the difference
  int halvings = 0;        ///< filled by backtrack

  bool is_accepted() const {
    return std::isfinite(difference) && std::isfinite(slope_end) &&
           sufficient_decrease(difference, share * slope_start, slope_end, noise);
  }
  /// Change of Phi.
  double change() const {
    return difference_or_mean(difference, share * slope_start, slope_end, noise);
  }
};

/// Halvings of a step after which a direction is given up.
inline constexpr int kMostHalvings = 12;

/// Halves a step until Phi falls along it (sufficient_decrease). Values and slopes that are not
/// finite do not count as a fall.
/// @param trial  trial(share, halvings) moves by that share of the step and returns a LineTrial.
///               The first one, share 1 at 0 halvings, may move by less where contact cuts the
///               step; the share that it returns is halved from there on.
/// @return the accepted trial; none if Phi does not fall at the start of the step, or at any share
///         within most_halvings halvings.
template <class Trial>
std::optional<LineTrial> backtrack(const Trial& trial, int most_halvings = kMostHalvings) {
  double share = 1;
  for (int halvings = 0; halvings <= most_halvings; ++halvings, share /= 2) {
    LineTrial found = trial(share, halvings);
    if (!(found.slope_start < 0)) return std::nullopt;
    found.halvings = halvings;
    if (found.is_accepted()) return found;
    share = found.share;
  }
  return std::nullopt;
}

}  // namespace elastogen
