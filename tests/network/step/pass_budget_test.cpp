// SPDX-License-Identifier: Apache-2.0
#include "network/step/pass_budget.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// Iterations that a stage may take; at most so many are asked for.
int64_t granted(PassBudget& budget, bool limited) {
  constexpr int64_t kAsked = 100000;
  budget.begin(limited);
  int64_t count = 0;
  while (count < kAsked && !budget.spend()) ++count;
  EXPECT_EQ(budget.spent(), count < kAsked);
  return count;
}

TEST(PassBudget, GrantsTenTimesWhatGoodStagesTook) {
  PassBudget budget;
  EXPECT_EQ(granted(budget, true), PassBudget::kLeast);
  for (int k = 0; k < 100; ++k) budget.learn(200);
  EXPECT_NEAR(double(granted(budget, true)), 2000, 1);
  for (int k = 0; k < 100; ++k) budget.learn(3);
  EXPECT_EQ(granted(budget, true), PassBudget::kLeast);
}

TEST(PassBudget, LeavesTheShortestStepsAlone) {
  PassBudget budget;
  EXPECT_EQ(granted(budget, false), 100000);
  budget.begin(false);
  EXPECT_FALSE(budget.spent());
}

}  // namespace
}  // namespace elastogen::test
