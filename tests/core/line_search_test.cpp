// SPDX-License-Identifier: Apache-2.0
#include "core/line_search.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace elastogen {
namespace {

/// f(a) = -a + k a^2/2, which records the shares that are tried.
struct Quadratic {
  double k;
  double cut = 1;  // share that remains of the first trial
  std::vector<double> shares = {};

  LineTrial operator()(double share, int halvings) {
    const double a = halvings == 0 ? share * cut : share;
    shares.push_back(a);
    return {.share = a,
            .difference = -a + k * a * a / 2,
            .slope_start = -1,
            .slope_end = a * (-1 + k * a)};
  }
};

TEST(LineSearch, AcceptsADecreaseOfAShareOfTheSlope) {
  EXPECT_TRUE(sufficient_decrease(-0.5, -1, 0, 0));
  EXPECT_TRUE(sufficient_decrease(-1e-4, -1, 5, 0));
  EXPECT_FALSE(sufficient_decrease(-0.9e-4, -1, 5, 0));
  EXPECT_FALSE(sufficient_decrease(0.1, -1, 1, 0));
}

TEST(LineSearch, LetsTheSlopesDecideWhereTheDifferenceIsNoise) {
  EXPECT_TRUE(sufficient_decrease(1e-12, -1e-13, 0.5e-13, 1e-11));
  EXPECT_FALSE(sufficient_decrease(1e-12, -1e-13, 2e-13, 1e-11));
  EXPECT_FALSE(sufficient_decrease(1e-10, -1e-13, 0, 1e-11));
}

TEST(LineSearch, MeanSlopeIsTheDifferenceOfAQuadratic) {
  // f(a) = -a + k a^2/2: both rules must say the same
  for (const double k : {0.5, 1.5, 1.9, 2.1, 3.0}) {
    const double difference = -1 + k / 2;
    const bool exact = sufficient_decrease(difference, -1, -1 + k, 0);
    EXPECT_EQ(sufficient_decrease(1e-3, -1, -1 + k, 1e-2), exact) << k;
  }
}

TEST(Backtrack, TakesAWholeStepThatFalls) {
  Quadratic f{1};
  const auto found = backtrack([&](double a, int halvings) { return f(a, halvings); });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->share, 1);
  EXPECT_EQ(found->halvings, 0);
  EXPECT_EQ(found->change(), -0.5);
  EXPECT_EQ(f.shares, std::vector<double>{1});
}

TEST(Backtrack, HalvesUntilTheFunctionFalls) {
  Quadratic f{10};  // falls below a = 1/5
  const auto found = backtrack([&](double a, int halvings) { return f(a, halvings); });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->share, 0.125);
  EXPECT_EQ(found->halvings, 3);
  EXPECT_EQ(f.shares, (std::vector<double>{1, 0.5, 0.25, 0.125}));
}

TEST(Backtrack, HalvesWhatACutHasLeft) {
  Quadratic f{10, 0.75};
  const auto found = backtrack([&](double a, int halvings) { return f(a, halvings); });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->share, 0.1875);
  EXPECT_EQ(f.shares, (std::vector<double>{0.75, 0.375, 0.1875}));
}

TEST(Backtrack, TakesNothingThatIsNotFinite) {
  // infinite in the core of a collider, no number where a voxel is turned inside out
  for (const double bad :
       {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
        std::numeric_limits<double>::quiet_NaN()}) {
    Quadratic f{1};
    const auto found = backtrack([&](double a, int halvings) {
      LineTrial trial = f(a, halvings);
      (halvings == 0 ? trial.difference : trial.slope_end) = halvings < 2 ? bad : -a;
      return trial;
    });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->halvings, 2) << bad;
  }
}

TEST(Backtrack, GivesUpAfterTheMostHalvings) {
  Quadratic f{1e30};
  EXPECT_FALSE(backtrack([&](double a, int halvings) { return f(a, halvings); }));
  EXPECT_EQ(f.shares.size(), 13u);
  f.shares.clear();
  EXPECT_FALSE(backtrack([&](double a, int halvings) { return f(a, halvings); }, 3));
  EXPECT_EQ(f.shares.back(), 0.125);
}

TEST(Backtrack, EndsAtOnceWhereNothingFalls) {
  for (const double slope : {0.0, 1.0, std::numeric_limits<double>::quiet_NaN()}) {
    int trials = 0;
    EXPECT_FALSE(backtrack([&](double, int) {
      ++trials;
      return LineTrial{.difference = -1, .slope_start = slope, .slope_end = -1};
    }));
    EXPECT_EQ(trials, 1) << slope;
  }
}

}  // namespace
}  // namespace elastogen
