// SPDX-License-Identifier: Apache-2.0
// Chooses between two methods for a task of every step: the one that cost less when both were tried
// last.

#pragma once

#include <cstdint>

namespace elastogen {

inline constexpr int kRetry = 10;      // steps after which the other one is tried again,
inline constexpr int kLateRetry = 40;  // or, where that cost this much more,
inline constexpr double kMuchDearer = 1.3;
inline constexpr double kFailed = 1e300;  // cost of a method that did not converge

class CheaperOf {
 public:
  /// @param enough  cost up to which the other method is not tried.
  explicit CheaperOf(double enough) : enough_(enough) {}

  /// The cheaper one, 0 or 1; 1 where neither converged.
  int better() const { return cost_[1] <= cost_[0] ? 1 : 0; }

  /// The method of a step: 0 at first, 1 no earlier than after kRetry steps unless 0 has failed.
  int choose(int64_t step) const {
    const int best = better(), other = 1 - best;
    if (cost_[best] <= enough_) return best;
    const bool lost = step_[other] > 0 && cost_[other] > kMuchDearer * cost_[best];
    const int64_t wait = lost ? kLateRetry : kRetry;
    return step - step_[other] >= wait ? other : best;
  }

  /// @param step  from 1 on.
  void take(int choice, int64_t step, double cost) { cost_[choice] = cost, step_[choice] = step; }

 private:
  double enough_, cost_[2] = {0, kFailed / 2};  // what is not known is better than a failure
  int64_t step_[2] = {};
};

}  // namespace elastogen
