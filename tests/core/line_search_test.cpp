// SPDX-License-Identifier: Apache-2.0
#include "core/line_search.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

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

}  // namespace
}  // namespace elastogen
