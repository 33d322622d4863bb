// SPDX-License-Identifier: Apache-2.0
#include "network/step/cheaper_of.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace elastogen {
namespace {

/// The choice of each of `steps` steps, if choice 0 costs `first` and choice 1 costs `second`.
std::vector<int> ways(CheaperOf choice, int steps, double first, double second) {
  std::vector<int> result;
  for (int step = 1; step <= steps; ++step) {
    result.push_back(choice.choose(step));
    choice.take(result.back(), step, result.back() == 0 ? first : second);
  }
  return result;
}

int count_of(const std::vector<int>& list, int way) {
  return int(std::count(list.begin(), list.end(), way));
}

TEST(CheaperOf, StaysWithWhatCostsLittle) {
  EXPECT_EQ(count_of(ways(CheaperOf(20), 200, 20, 1), 1), 0);
}

TEST(CheaperOf, GoesOverToTheCheaperWayAndLooksBack) {
  const std::vector<int> list = ways(CheaperOf(20), 200, 100, 50);
  EXPECT_EQ(count_of({list.begin(), list.begin() + kRetry - 1}, 0), kRetry - 1);
  EXPECT_EQ(list[kRetry - 1], 1);
  EXPECT_EQ(count_of(list, 0), kRetry - 1 + (200 - kRetry) / kLateRetry);
}

TEST(CheaperOf, LooksBackMoreOftenWhereTheyAreClose) {
  const std::vector<int> list = ways(CheaperOf(20), 200, 50, 55);
  EXPECT_EQ(count_of(list, 1), 200 / kRetry);
}

TEST(CheaperOf, LeavesAWayThatFailsAtOnce) {
  const std::vector<int> list = ways(CheaperOf(20), 30, kFailed, 50);
  EXPECT_EQ(count_of(list, 0), 1);
  EXPECT_EQ(list[0], 0);
  EXPECT_EQ(count_of(ways(CheaperOf(20), 9, kFailed, kFailed), 0), 1);
}

}  // namespace
}  // namespace elastogen
