// SPDX-License-Identifier: Apache-2.0
// One line of progress on stderr, rewritten in place; nothing if stderr is no terminal.

#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace elastogen {

class Progress {
 public:
  /// @param total  number of frames that follow.
  /// @param quiet  never show anything.
  Progress(int64_t total, bool quiet);
  /// Removes the line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows how many frames are done, the residual of the last step and the time left, at most ten
  /// times a second and at the end. Drafts are yellow unless NO_COLOR is set.
  void update(int64_t done, double residual, bool converged);

 private:
  using Clock = std::chrono::steady_clock;

  int64_t total_;
  bool shown_, coloured_;
  Clock::time_point start_ = Clock::now(), last_ = {};
};

/// A duration for people: "4.2 s", "3 min 05 s", "2 h 07 min". @param seconds  [s], >= 0.
std::string duration_text(double seconds);

/// The line that Progress shows, without control characters.
/// @param seconds  time since the start [s]; the rest is estimated as if frames took equal times.
std::string progress_line(int64_t done, int64_t total, double residual, bool converged,
                          double seconds);

}  // namespace elastogen
