// SPDX-License-Identifier: Apache-2.0
// Steps along a descent direction: when one is accepted, and how it is shortened until it is.
//
// Phi is what falls, as a function of the share of the step that is gone. Slopes are its
// derivatives.

#pragma once

#include <cmath>
#include <optional>

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

/// What is found at a share of a step.
struct LineTrial {
  double share = 1;        ///< that was gone
  double difference = 0;   ///< Phi(share) - Phi(0)
  double slope_start = 0;  ///< Phi'(0), of the whole step
  double slope_end = 0;    ///< share Phi'(share), of what was gone
  double noise = 0;        ///< bound on the rounding error of the difference
  int halvings = 0;        ///< filled by backtrack

  bool is_accepted() const {
    return std::isfinite(difference) && std::isfinite(slope_end) &&
           sufficient_decrease(difference, share * slope_start, slope_end, noise);
  }
  /// What Phi has changed by.
  double change() const {
    return difference_or_mean(difference, share * slope_start, slope_end, noise);
  }
};

/// Halvings of a step after which a direction is given up.
inline constexpr int kMostHalvings = 12;

/// Halves a step until Phi falls along it (sufficient_decrease); values and slopes that are not
/// finite are no fall.
/// @param trial  trial(share, halvings) goes that share of the step and says what it found, as a
///               LineTrial. The first one, of share 1 at 0 halvings, may go less, where contact
///               cuts the step: what it says it went is halved from there on.
/// @return the accepted trial; none where Phi does not fall at the start of the step, or at no
///         share of most_halvings halvings.
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
