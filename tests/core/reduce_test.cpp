// SPDX-License-Identifier: Apache-2.0
#include "core/reduce.hpp"

#include "core/parallel.hpp"

#include <gtest/gtest.h>

#include <random>

namespace elastogen {
namespace {

template <class T>
std::vector<T> random_values(int64_t n, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<T> values(static_cast<size_t>(n));
  for (T& value : values) value = T(normal(random) * std::pow(10, normal(random)));
  return values;
}

constexpr int64_t kSizes[] = {0, 1, 7, 8, 9, 2047, 2048, 2049, 100003};

template <class T>
void expect_dot() {
  for (const int64_t n : kSizes) {
    const std::vector<T> a = random_values<T>(n, 1), b = random_values<T>(n, 2);
    long double sum = 0, size = 0;
    for (size_t k = 0; k < a.size(); ++k) {
      sum += static_cast<long double>(a[k]) * b[k];
      size += std::abs(static_cast<long double>(a[k]) * b[k]);
    }
    EXPECT_NEAR(dot(a.data(), b.data(), n), double(sum), 1e-14 * double(size)) << n;
  }
}

TEST(Reduce, DotIsASumInDoubleForEitherFormat) {
  expect_dot<double>();
  expect_dot<float>();
}

TEST(Reduce, NormOfAKnownVector) {
  const float a[3] = {2, 3, 6};
  EXPECT_EQ(norm(a, 3), 7);
}

TEST(Reduce, AddScaledReachesEveryEntry) {
  for (const int64_t n : kSizes) {
    const std::vector<double> x = random_values<double>(n, 3);
    std::vector<double> y = random_values<double>(n, 4);
    const std::vector<double> before = y;
    add_scaled(0.5, x.data(), y.data(), n);
    for (size_t k = 0; k < y.size(); ++k) ASSERT_EQ(y[k], before[k] + 0.5 * x[k]);
  }
}

TEST(Reduce, LargestIsThatOfAllBlocksAndZeroOfNone) {
  for (const int64_t n : kSizes) {
    const std::vector<double> values = random_values<double>(n, 7);
    const auto value = [&](int64_t k) { return std::abs(values[size_t(k)]); };
    double most = 0;
    for (int64_t k = 0; k < n; ++k) most = std::max(most, value(k));
    EXPECT_EQ(largest(n, value), most);
  }
}

TEST(Parallel, GroupedHasEachNumberInItsGroupInOrder) {
  for (const int64_t n : kSizes) {
    const auto group = [](int64_t i) { return i * i % 7 - 1; };  // -1, 0, 1, 3
    const std::vector<std::vector<int32_t>> groups = grouped(n, 5, group);
    std::vector<std::vector<int32_t>> expected(5);
    for (int64_t i = 0; i < n; ++i)
      if (group(i) >= 0) expected[size_t(group(i))].push_back(int32_t(i));
    EXPECT_EQ(groups, expected);
    EXPECT_EQ(filtered(n, [&](int64_t i) { return group(i) == 3; }), expected[3]);
  }
}

TEST(Reduce, SumsHaveTheSameBitsOnOneAndTwoThreads) {
  const std::vector<float> a = random_values<float>(100003, 5), b = random_values<float>(100003, 6);
  const auto with = [&](size_t threads) {
    const ThreadLimit limit(threads);
    return dot(a.data(), b.data(), 100003);
  };
  const double one = with(1);
  for (int k = 0; k < 50; ++k) ASSERT_EQ(with(2), one);
}

TEST(Reduce, OrderedSumAddsTheBlocksInTheirOrder) {
  // 1e16 swallows every 1 that comes after it, and none that comes before
  const auto partial = [](int64_t begin, int64_t) { return begin == 0 ? 1e16 : 1.0; };
  EXPECT_EQ(ordered_sum(5 * kBlock, partial), 1e16);
  const auto late = [](int64_t begin, int64_t) { return begin == 4 * kBlock ? 1e16 : 1.0; };
  EXPECT_EQ(ordered_sum(5 * kBlock, late), 1e16 + 4);
}

TEST(Parallel, BlocksCoverEachIndexOnce) {
  for (const int64_t n : kSizes)
    for (const int64_t block : {int64_t(3), kBlock}) {
      std::vector<int> seen(static_cast<size_t>(n), 0);
      for_blocks(
          n,
          [&](int64_t begin, int64_t end) {
            EXPECT_LE(end - begin, block);
            for (int64_t k = begin; k < end; ++k) ++seen[static_cast<size_t>(k)];
          },
          block);
      for_each(
          n, [&](int64_t k) { ++seen[static_cast<size_t>(k)]; }, block);
      for (const int count : seen) ASSERT_EQ(count, 2);
    }
}

}  // namespace
}  // namespace elastogen
