// SPDX-License-Identifier: Apache-2.0
#include "core/parallel_sort.hpp"

#include "core/parallel.hpp"
#include "tests/core/random_keys.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace elastogen {
namespace {

TEST(ParallelSort, KeepsTheOrderOfEqualKeys) {
  const std::vector<uint32_t> keys = {7, 3, 7, 0, 3, 3};
  std::vector<uint32_t> sorted(6);
  std::vector<int32_t> order(6);
  sort_with_order(keys.data(), 6, sorted.data(), order.data());
  EXPECT_EQ(sorted, (std::vector<uint32_t>{0, 3, 3, 3, 7, 7}));
  EXPECT_EQ(order, (std::vector<int32_t>{3, 1, 4, 5, 0, 2}));
}

TEST(ParallelSort, OrderIsThatOfAStableSortOnAnyNumberOfThreads) {
  const std::vector<uint64_t> keys = test::random_keys<uint64_t>(50000, 12);
  std::vector<int32_t> expected(keys.size());
  std::iota(expected.begin(), expected.end(), 0);
  std::stable_sort(expected.begin(), expected.end(),
                   [&](int32_t a, int32_t b) { return keys[size_t(a)] < keys[size_t(b)]; });
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    std::vector<uint64_t> sorted(keys.size());
    std::vector<int32_t> order(keys.size());
    sort_with_order(keys.data(), int64_t(keys.size()), sorted.data(), order.data());
    EXPECT_EQ(order, expected);
    EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));
  }
}

TEST(ParallelSort, TakesNoKeys) {
  sort_with_order<uint32_t>(nullptr, 0, nullptr, nullptr);
}

}  // namespace
}  // namespace elastogen
