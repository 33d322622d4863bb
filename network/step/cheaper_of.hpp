// SPDX-License-Identifier: Apache-2.0
// Of two ways to do something once a step, the one that was cheaper when both were done last.

#pragma once

#include <cstdint>

namespace elastogen {

inline constexpr int kRetry = 10;      // steps after which the other way is tried again,
inline constexpr int kLateRetry = 40;  // or, where that cost this much more,
inline constexpr double kMuchDearer = 1.3;
inline constexpr double kFailed = 1e300;  // cost of a way that did not get there

class CheaperOf {
 public:
  /// @param enough  what a way may cost without the other being tried.
  explicit CheaperOf(double enough) : enough_(enough) {}

  /// Way 1 where neither got there.
  int better() const { return cost_[1] <= cost_[0] ? 1 : 0; }

  /// The way of a step: 0 at first, 1 no earlier than kRetry steps in unless 0 has failed.
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
