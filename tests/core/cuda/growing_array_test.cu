// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/growing_array.cuh"
#include "tests/support/on_card.hpp"

namespace elastogen::test {
namespace {

class GrowingArray : public OnCard {};

TEST_F(GrowingArray, KeepsItsNumbersWhileItGrows) {
  cuda::GrowingArray<int32_t> array;
  std::vector<int32_t> expected = {1, 2, 3};
  array.upload(expected);
  for (const int64_t size : {4, 9, 1000, 1001}) {
    array.resize(size);
    expected.resize(size_t(size));
    EXPECT_EQ(array.size(), size);
    EXPECT_GE(array.capacity(), size);
    EXPECT_EQ(array.download(), expected);
  }
}

TEST_F(GrowingArray, StaysInPlaceWithinItsCapacity) {
  cuda::GrowingArray<double> array;
  array.reserve(100);
  EXPECT_EQ(array.size(), 0);
  const double* const place = array.data();
  array.upload({4, 5, 6});
  array.resize(100);
  EXPECT_EQ(array.capacity(), 100);
  EXPECT_EQ(array.data(), place);
}

TEST_F(GrowingArray, NumbersThatComeAgainAreZero) {
  cuda::GrowingArray<int32_t> array;
  array.upload({1, 2, 3});
  array.resize(1);
  EXPECT_EQ(array.download(), std::vector<int32_t>{1});
  array.resize(3);
  EXPECT_EQ(array.download(), (std::vector<int32_t>{1, 0, 0}));
}

TEST_F(GrowingArray, HoldsNoNumbers) {
  cuda::GrowingArray<int32_t> array;
  array.resize(0);
  EXPECT_TRUE(array.download().empty());
}

}  // namespace
}  // namespace elastogen::test
