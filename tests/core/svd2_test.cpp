// SPDX-License-Identifier: Apache-2.0
#include "core/svd2.hpp"

#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

Mat3<double> plane(double a, double b, double c, double d, double third = 1) {
  return {a, b, 0, c, d, 0, 0, 0, third};
}

Mat3<double> product(const Svd3<double>& s) {
  Mat3<double> US;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) US(i, j) = s.U(i, j) * s.sigma[j];
  return times_transposed(US, s.V);
}

void expect_decomposition(const Mat3<double>& F) {
  const Svd3<double> s = plane_svd(F);
  double size = 0;
  for (const double f : F.m) size = std::fmax(size, std::abs(f));
  const Mat3<double> again = product(s);
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(again.m[k], F.m[k], 1e-15 * 4 * size);
  EXPECT_NEAR(determinant(s.U), 1, 1e-15);
  EXPECT_NEAR(determinant(s.V), 1, 1e-15);
  EXPECT_GE(s.sigma[0], std::abs(s.sigma[1]));
  EXPECT_EQ(s.sigma[2], F(2, 2));
}

TEST(PlaneSvd, DecomposesRandomMatrices) {
  test::Random random(7);
  std::uniform_real_distribution<double> in(-2, 2);
  for (int k = 0; k < 10000; ++k)
    expect_decomposition(plane(in(random), in(random), in(random), in(random), in(random)));
}

TEST(PlaneSvd, DecomposesSpecialMatrices) {
  expect_decomposition(plane(1, 0, 0, 1));
  expect_decomposition(plane(0, 0, 0, 0));
  expect_decomposition(plane(1, 0, 0, -1));
  expect_decomposition(plane(0, 1, 1, 0));
  expect_decomposition(plane(1, 2, 2, 4));
  expect_decomposition(plane(1e-200, 0, 0, 1e-200));
  expect_decomposition(plane(1e200, 1e200, -1e200, 1e200));
}

TEST(PlaneSvd, KeepsTheThirdStretchThirdAndTheSignOfThePlane) {
  const Svd3<double> thick = plane_svd(plane(2, 0, 0, 3, 5));
  EXPECT_DOUBLE_EQ(thick.sigma[0], 3);
  EXPECT_DOUBLE_EQ(thick.sigma[1], 2);
  EXPECT_DOUBLE_EQ(thick.sigma[2], 5);
  EXPECT_LT(plane_svd(plane(0, 1, 1, 0)).sigma[1], 0);
}

TEST(PlaneSvd, AgreesWithTheOneInSpace) {
  test::Random random(8);
  std::uniform_real_distribution<double> in(-2, 2);
  for (int k = 0; k < 1000; ++k) {
    // a third stretch below the others, which svd3 leaves third
    const Mat3<double> F = plane(in(random), in(random), in(random), in(random), 0);
    const Svd3<double> s = plane_svd(F), t = svd3(F);
    EXPECT_NEAR(s.sigma[0], t.sigma[0], 1e-14);
    EXPECT_NEAR(std::abs(s.sigma[1]), t.sigma[1], 1e-14);
  }
}

}  // namespace
}  // namespace elastogen
