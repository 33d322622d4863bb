// SPDX-License-Identifier: Apache-2.0
#include "core/array.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace elastogen {
namespace {

double sum(In<double> values) {
  double total = 0;
  for (int64_t k = 0; k < values.size(); ++k) total += values.data[k];
  return total;
}

TEST(Array, IsZeroAtBirthAndRowMajor) {
  Array<double> a(3, 2);
  EXPECT_EQ(sum(a), 0);
  a(1, 0) = 5, a(2, 1) = 7;
  EXPECT_EQ(a.data()[2], 5);
  EXPECT_EQ(a.data()[5], 7);
  EXPECT_EQ(a.row(1), a.data() + 2);
  EXPECT_EQ(a.size(), 6);
}

TEST(Array, IsZeroAtBirthWhereMemoryWasInUseBefore) {
  for (const int64_t rows : {1, 100, 5000, 3000000})
    for (int repeat = 0; repeat < 2; ++repeat) {
      Array<double> a(rows, 2);
      EXPECT_EQ(sum(a), 0);
      a.fill(3);
      EXPECT_EQ(sum(a), 6 * double(rows));
    }
}

TEST(Array, EmptyHasNoRows) {
  const Array<int32_t> a;
  EXPECT_TRUE(a.empty());
  EXPECT_EQ(a.size(), 0);
  EXPECT_FALSE(Array<int32_t>(1).empty());
}

TEST(Array, EqualityIsShapeAndValues) {
  Array<double> a(2, 3), b(3, 2);
  EXPECT_FALSE(a == b);
  Array<double> c = a;
  EXPECT_TRUE(a == c);
  c(1, 2) = 1;
  EXPECT_FALSE(a == c);
}

TEST(Array, FillKeepsTheShape) {
  Array<float> a(4, 3);
  a.fill(2);
  EXPECT_EQ(a.rows(), 4);
  EXPECT_EQ(a.cols(), 3);
  EXPECT_EQ(a(3, 2), 2);
}

TEST(Span, ViewsTheOwnersMemory) {
  Array<double> a(2, 3);
  const Span<double> view = a;
  view(1, 1) = 4;
  EXPECT_EQ(a(1, 1), 4);
  const Span<const double> constant = view;
  EXPECT_EQ(constant.row(1)[1], 4);
  EXPECT_TRUE(constant.is(2, 3));
  EXPECT_FALSE(constant.is(3, 2));
  std::ostringstream text;
  text << constant;
  EXPECT_EQ(text.str(), "(2, 3)");
}

}  // namespace
}  // namespace elastogen
