// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/compare.hpp"

#include <gtest/gtest.h>

namespace elastogen::mpm {
namespace {

constexpr double kSpacing = 0.1;

/// Four particles a cell in a rectangle of cells.
Particles rectangle(int first, int cells, int height) {
  Array<double> x(4 * cells * height, 3);
  for (int64_t k = 0; k < x.rows(); ++k) {
    x(k, 0) = kSpacing * (first + (double(k % (2 * cells)) + 0.5) / 2);
    x(k, 1) = kSpacing * (double(k / (2 * cells)) + 0.5) / 2;
  }
  return particles_at(x, kSpacing * kSpacing / 4, 0, 1000);
}

constexpr double kFull = 1000 * kSpacing * kSpacing;

TEST(Compare, IsOneForTheSameParticlesAndZeroForOthersFarAway) {
  const Particles a = rectangle(0, 20, 20), far = rectangle(100, 20, 20);
  const Likeness same = compare(a, a, 2, kSpacing, kFull);
  EXPECT_NEAR(same.iou_weighted, 1, 1e-15);
  EXPECT_EQ(same.iou_binary, 1);
  EXPECT_NEAR(same.iou_soft_scaled, 1, 1e-15);
  EXPECT_LT(same.iou_soft, 1);
  const Likeness none = compare(a, far, 2, kSpacing, kFull);
  EXPECT_EQ(none.iou_weighted, 0);
  EXPECT_EQ(none.iou_binary, 0);
  EXPECT_EQ(none.iou_soft, 0);
}

TEST(Compare, IsTheShareOfWhatRectanglesHaveInCommon) {
  // three quarters of each: 30 cells of 50; at the edges mass is spread over three nodes alike
  const Particles a = rectangle(0, 40, 20), b = rectangle(10, 40, 20);
  const Likeness half = compare(a, b, 2, kSpacing, kFull);
  EXPECT_NEAR(half.iou_weighted, 30.0 / 50, 1e-12);
  EXPECT_NEAR(half.iou_binary, 30.0 / 50, 0.03);
  const Likeness turned = compare(b, a, 2, kSpacing, kFull);
  EXPECT_EQ(turned.iou_weighted, half.iou_weighted);
  EXPECT_NEAR(turned.iou_soft, half.iou_soft, 1e-15);
}

}  // namespace
}  // namespace elastogen::mpm
