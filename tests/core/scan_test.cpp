// SPDX-License-Identifier: Apache-2.0
#include "core/scan.hpp"

#include "tests/core/random_keys.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

TEST(Scan, SumsWhatStandsBefore) {
  const std::vector<int32_t> values = {3, 0, -1, 5};
  std::vector<int32_t> sums(5, 9);
  exclusive_sum(values.data(), 4, sums.data());
  EXPECT_EQ(sums, (std::vector<int32_t>{0, 3, 3, 2, 7}));
}

TEST(Scan, SumsOverBlocksAreThoseOfOneLoop) {
  const std::vector<uint64_t> keys = test::random_keys<uint64_t>(3 * kBlock + 5, 40);
  const std::vector<int64_t> values(keys.begin(), keys.end());
  std::vector<int64_t> sums(values.size() + 1), expected = {0};
  for (const int64_t value : values) expected.push_back(expected.back() + value);
  exclusive_sum(values.data(), int64_t(values.size()), sums.data());
  EXPECT_EQ(sums, expected);
}

TEST(Scan, TakesNoNumbers) {
  int32_t sum = 9;
  exclusive_sum<int32_t>(nullptr, 0, &sum);
  EXPECT_EQ(sum, 0);
}

}  // namespace
}  // namespace elastogen
