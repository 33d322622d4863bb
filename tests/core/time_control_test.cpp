// SPDX-License-Identifier: Apache-2.0
#include "core/time_control.hpp"

#include "core/time_error.hpp"
#include "core/time_scheme.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace elastogen {
namespace {

TEST(TimeControl, ALevelDividesWhatIsLeftIntoEqualSteps) {
  TimeControl control;
  EXPECT_EQ(control.step(1, 1), 1);
  for (int level = 1; level < TimeControl::kMostLevel; ++level) {
    EXPECT_FALSE(control.accepts(1.01));
    EXPECT_EQ(control.level(), level);
    EXPECT_EQ(control.step(1, 1), 1.0 / (1 << (level - 1)));
  }
  EXPECT_EQ(control.step(0.5, 1), 0.125);    // level 4, of 8 steps
  EXPECT_EQ(control.step(0.3, 1), 0.3 / 3);  // which 0.125 does not divide
  EXPECT_EQ(control.step(1e-3, 1), 1e-3);
}

TEST(TimeControl, ALargeErrorSkipsLevelsAndTheHighestOneIsTaken) {
  TimeControl control;
  EXPECT_FALSE(control.accepts(1e9));
  EXPECT_EQ(control.level(), 3);  // three at once, not more
  EXPECT_FALSE(control.accepts(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(control.level(), 5);
  EXPECT_TRUE(control.accepts(100));
}

TEST(TimeControl, EachIntervalTriesALevelLowerAndWaitsWhereThatFails) {
  TimeControl control;
  control.begin_interval();
  EXPECT_FALSE(control.accepts(10));
  const int level = control.level();
  ASSERT_GT(level, 1);
  int tries[3] = {}, intervals = 0;
  for (int found = 0; found < 3; ++intervals) {
    control.begin_interval();
    if (control.level() == level) {
      EXPECT_TRUE(control.accepts(0.5));
      continue;
    }
    EXPECT_EQ(control.level(), level - 1);
    EXPECT_FALSE(control.accepts(1.5));
    tries[found++] = intervals;
  }
  EXPECT_EQ(tries[0], 0);
  EXPECT_EQ(tries[1] - tries[0], 5);  // 4 intervals between
  EXPECT_EQ(tries[2] - tries[1], 9);  // 8
}

TEST(TimeControl, ASmallErrorLowersTheLevelWithinAnInterval) {
  TimeControl control;
  EXPECT_FALSE(control.accepts(1e9));
  EXPECT_TRUE(control.accepts(0.2));
  EXPECT_EQ(control.level(), 3);
  EXPECT_TRUE(control.accepts(0.1));
  EXPECT_TRUE(control.accepts(0.1));
  EXPECT_EQ(control.level(), 1);
  EXPECT_TRUE(control.accepts(0));  // BDF2 starts with an interval
  EXPECT_EQ(control.level(), 1);
}

/// Weights of the velocities give the leading term of the error of a scheme for e = t^2, t^3, ...:
/// none for a velocity that changes evenly, and for e = t^2, of which d''' = 2, C h^3 d'''.
TEST(TimeError, WeightsSeeTheThirdDerivativeAlone) {
  const auto weighed = [](const TimeStage& stage, double t_b, double power) {
    const StepWeights w = step_weights(stage);
    return w.end * std::pow(stage.t, power) + w.other * std::pow(t_b, power) +
           (power == 0 ? w.start : 0);
  };
  const double h = 0.2;
  for (const double h_before : {0.2, 0.1, 0.3}) {
    const TimeStage bdf = bdf2_stage(h, h_before);
    const double r = h / h_before;
    EXPECT_NEAR(weighed(bdf, -h_before, 0), 0, 1e-14);
    EXPECT_NEAR(weighed(bdf, -h_before, 1), 0, 1e-14);
    EXPECT_NEAR(weighed(bdf, -h_before, 2),
                (1 + r) * (1 + r) / (6 * r * (1 + 2 * r)) * 2 * h * h * h, 1e-14);
  }
  const TimeStage sdirk = sdirk2_stage(1, h);
  EXPECT_NEAR(weighed(sdirk, sdirk.t_b, 0), 0, 1e-14);
  EXPECT_NEAR(weighed(sdirk, sdirk.t_b, 1), 0, 1e-14);
  // |1/6 - s + s^2 / 2 ... |: the error of SDIRK2 for d''' = 2 is 2 (3 sqrt(2) - 4)/6 h^3
  EXPECT_NEAR(std::abs(weighed(sdirk, sdirk.t_b, 2)), (3 * std::sqrt(2.0) - 4) / 3 * h * h * h,
              2e-3 * h * h * h);
}

TEST(TimeError, SaysOfSmallImpactsWhatItSpendsNoStepsOn) {
  // a body of 0.2 m, whose bounces count from 2 mm on: 0.198 m/s
  const double g = 9.81, T = 1.0 / 30, size = 0.2, u = 1e-3;
  const auto of = [&](double closing, double struck) {
    return contact_error(closing, struck, g, T, size, u);
  };
  const ContactError rests = of(0.1, 0.1), meets = of(0.25, 0), jolted = of(0.1, 0.25),
                     lands = of(2, 0);
  EXPECT_EQ(rests.counted, 0);
  EXPECT_EQ(rests.said, 0);
  EXPECT_NEAR(meets.counted, 0.25 / g * u, 1e-18);  // as long as the bounce rises
  EXPECT_EQ(meets.said, T * u);
  EXPECT_EQ(jolted.counted, 0);
  EXPECT_EQ(jolted.said, T * u);
  EXPECT_EQ(lands.counted, T * u);
  EXPECT_EQ(lands.said, T * u);
  // where nothing pulls it, it counts for all of the frame
  EXPECT_EQ(contact_error(1e-3, 0, 0, T, size, u).counted, T * u);
  EXPECT_EQ(contact_error(1e-3, 0, 0, T, size, u).said, T * u);
}

}  // namespace
}  // namespace elastogen
