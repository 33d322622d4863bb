// SPDX-License-Identifier: Apache-2.0
#include "cli/progress.hpp"

#include "cli/signals.hpp"

#include <gtest/gtest.h>

#include <csignal>

namespace elastogen {
namespace {

TEST(Progress, SpellsDurationsForPeople) {
  EXPECT_EQ(duration_text(0), "0.0 s");
  EXPECT_EQ(duration_text(4.24), "4.2 s");
  EXPECT_EQ(duration_text(59.97), "1 min 00 s");
  EXPECT_EQ(duration_text(185), "3 min 05 s");
  EXPECT_EQ(duration_text(3599.6), "1 h 00 min");
  EXPECT_EQ(duration_text(7620), "2 h 07 min");
}

TEST(Progress, EstimatesTheTimeLeftFromTheFramesDone) {
  EXPECT_EQ(progress_line(30, 120, 4.2e-4, true, 10),
            "frame 30/120  converged 4.2e-04  30.0 s left");
  EXPECT_EQ(progress_line(120, 120, 2e-3, false, 10), "frame 120/120  draft 2.0e-03  0.0 s left");
  EXPECT_EQ(progress_line(0, 120, 0, true, 10), "frame 0/120  converged 0.0e+00");
}

TEST(SignalsDeathTest, RemembersTheFirstAndEndsAtTheSecond) {
  const auto twice = [](int signal) {
    watch_signals();
    if (pending_signal() != 0) _exit(1);
    std::raise(signal);
    if (pending_signal() != signal) _exit(2);
    std::raise(signal);
    _exit(3);
  };
  EXPECT_EXIT(twice(SIGINT), testing::ExitedWithCode(130), "");
  EXPECT_EXIT(twice(SIGTERM), testing::ExitedWithCode(143), "");
}

}  // namespace
}  // namespace elastogen
