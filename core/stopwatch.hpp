// SPDX-License-Identifier: Apache-2.0
// Wall time since a point of the run.

#pragma once

#include <chrono>

namespace elastogen {

/// Runs from its construction.
class Stopwatch {
 public:
  /// [s]
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  double milliseconds() const { return 1e3 * seconds(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace elastogen
