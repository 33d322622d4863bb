// SPDX-License-Identifier: Apache-2.0
// How long a stage is iterated where shorter steps are another way out: ten times as long as those
// that went well.

#pragma once

#include <algorithm>
#include <cstdint>

namespace elastogen {

class PassBudget {
 public:
  static constexpr int kTimes = 10;
  static constexpr int64_t kLeast = 300;  ///< iterations that are always allowed

  /// Before a stage.
  /// @param limited  false: as many iterations as the loops themselves allow.
  void begin(bool limited) {
    limited_ = limited;
    left_ = std::max(kLeast, int64_t(kTimes * mean_));
  }
  /// Takes one iteration. @return whether there was none left.
  bool spend() { return limited_ && --left_ < 0; }
  bool spent() const { return limited_ && left_ < 0; }
  /// Takes note of the iterations of a stage that went well.
  void learn(int64_t iterations) { mean_ += (double(iterations) - mean_) / 8; }

 private:
  bool limited_ = false;
  int64_t left_ = 0;
  double mean_ = 0;
};

}  // namespace elastogen
