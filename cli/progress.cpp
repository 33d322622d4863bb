// SPDX-License-Identifier: Apache-2.0
#include "cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace elastogen {

namespace {

constexpr std::chrono::milliseconds kShortestInterval{100};
constexpr const char* kEraseLine = "\r\033[K";
constexpr const char* kYellow = "\033[33m";
constexpr const char* kPlain = "\033[0m";

// by convention NO_COLOR counts if it is set and not empty
bool wants_colour() {
  const char* value = std::getenv("NO_COLOR");
  return value == nullptr || *value == '\0';
}

}  // namespace

std::string duration_text(double seconds) {
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  const int64_t minutes = (whole + 30) / 60;
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string progress_line(int64_t done, int64_t total, double residual, bool converged,
                          double seconds) {
  std::string line = fmt::format("frame {}/{}  {} {:.1e}", done, total,
                                 converged ? "converged" : "draft", residual);
  if (done > 0) {
    const double left = seconds / double(done) * double(total - done);
    line += fmt::format("  {} left", duration_text(left));
  }
  return line;
}

Progress::Progress(int64_t total, bool quiet)
    : total_(total), shown_(!quiet && isatty(STDERR_FILENO) == 1), coloured_(wants_colour()) {}

Progress::~Progress() {
  if (shown_) std::fputs(kEraseLine, stderr);
}

void Progress::update(int64_t done, double residual, bool converged) {
  const Clock::time_point now = Clock::now();
  if (!shown_ || (done < total_ && now - last_ < kShortestInterval)) return;
  last_ = now;
  const std::chrono::duration<double> elapsed = now - start_;
  const std::string line = progress_line(done, total_, residual, converged, elapsed.count());
  const bool yellow = coloured_ && !converged;
  fmt::print(stderr, "{}{}{}{}", kEraseLine, yellow ? kYellow : "", line, yellow ? kPlain : "");
  std::fflush(stderr);
}

}  // namespace elastogen
