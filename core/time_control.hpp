// SPDX-License-Identifier: Apache-2.0
// How many steps an interval T takes, for a time error within its tolerance (time_error.hpp). Level
// 0 is one step of BDF2, levels 1 to 5 are 1, 2, 4, 8 and 16 steps of SDIRK2. A step whose error is
// too large is made again on a higher level; at the highest one it is taken as it is. Each interval
// begins one level lower than the last one ended; where that fails it is not tried again for 4, 8,
// 16, 32 intervals. An impact that can be foreseen begins at level 3.

#pragma once

#include <algorithm>
#include <cmath>

namespace elastogen {

class TimeControl {
 public:
  static constexpr int kMostLevel = 5;
  static constexpr int kImpactLevel = 3;  ///< where an impact begins

  int level() const { return level_; }
  /// Call at the start of each interval.
  void begin_interval() {
    if (tries_) failures_ = 0;  // the lower level has held
    tries_ = level_ > 0 && wait_ == 0;
    if (tries_) --level_;
    if (wait_ > 0) --wait_;
  }
  /// Length of the next of equal steps over what is left of an interval.
  double step(double left, double interval) const {
    const double longest = interval / double(1 << std::max(0, level_ - 1));
    return left / std::ceil(left / longest - 1e-6);
  }
  /// Takes the error of a step over its tolerance. @return false: make it again on the new level.
  bool accepts(double ratio) {
    if (!(ratio <= 1) && level_ < kMostLevel) {
      const double factor = std::isfinite(ratio) ? ratio : 16;  // halving the steps gives 1/4
      const int more = int(std::ceil(std::log2(factor) / 2 - 0.3));
      level_ = std::min(kMostLevel, level_ + std::clamp(more, 1, 3));
      if (tries_) wait_ = 4 << std::min(3, failures_++);
      tries_ = false;
      return false;
    }
    if (ratio < 0.125 && level_ > 1) --level_;
    return true;
  }
  /// A body in flight is about to meet a collider: no step of a lower level could be accepted.
  void expect_impact() {
    level_ = std::max(level_, kImpactLevel);
    tries_ = false;
  }

 private:
  int level_ = 0;
  int wait_ = 0, failures_ = 0;  // intervals
  bool tries_ = false;           // a level lower than that of the last interval
};

}  // namespace elastogen
