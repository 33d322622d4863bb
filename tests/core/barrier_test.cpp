// SPDX-License-Identifier: Apache-2.0
#include "core/barrier.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace elastogen {
namespace {

TEST(Barrier, DerivativesAreThoseOfTheValue) {
  for (const double s : {0.01, 0.1, 0.37, 0.8, 0.99}) {
    const double d = 1e-5 * s;
    const double first = (barrier(s + d).value - barrier(s - d).value) / (2 * d);
    const double second = (barrier(s + d).first - barrier(s - d).first) / (2 * d);
    EXPECT_NEAR(barrier(s).value, -(1 - s) * (1 - s) * std::log(s), 1e-14);
    EXPECT_NEAR(barrier(s).first, first, 1e-7 * (1 + std::abs(first)));
    EXPECT_NEAR(barrier(s).second, second, 1e-7 * (1 + std::abs(second)));
  }
}

TEST(Barrier, IsConvexAndRepelsUpToContact) {
  double before = std::numeric_limits<double>::infinity();
  for (double s = 1e-12; s < 1; s *= 1.3) {
    const Curve b = barrier(s);
    EXPECT_LT(b.value, before);
    EXPECT_LT(b.first, 0);
    EXPECT_GT(b.second, 0);
    before = b.value;
  }
}

TEST(Barrier, GoesOnAsItsTaylorPolynomialBelowTheCut) {
  const double c = kBarrierCut, l = std::log(c), r = 1 - c;
  const double first = 2 * r * l - r * r / c, second = -2 * l + 4 * r / c + r * r / (c * c);
  for (const double s : {0.0, 1e-9, 0.3 * c, c * (1 - 1e-12)}) {
    const double d = s - c;
    EXPECT_NEAR(barrier(s).value, -r * r * l + d * first + d * d / 2 * second, 1e-12);
    EXPECT_NEAR(barrier(s).first, first + d * second, 1e-9 * std::abs(first));
    EXPECT_NEAR(barrier(s).second, second, 1e-9 * second);
  }
}

TEST(Barrier, EndsTwiceContinuouslyDifferentiable) {
  for (const double s : {1.0, 1.5, 1e9}) {
    EXPECT_EQ(barrier(s).value, 0);
    EXPECT_EQ(barrier(s).first, 0);
    EXPECT_EQ(barrier(s).second, 0);
  }
  const Curve inside = barrier(1 - 1e-6);
  EXPECT_NEAR(inside.value, 0, 1e-17);
  EXPECT_NEAR(inside.first, 0, 1e-11);
  EXPECT_NEAR(inside.second, 0, 1e-5);
}

TEST(SmoothedSlip, ForceOverSlipIsTheDerivativeOverTheSlip) {
  constexpr double e = 0.3, d = 1e-6;
  for (const double y : {0.01, 0.1, 0.29, 0.31, 2.0}) {
    const double slope = (smoothed_slip(y + d, e).value - smoothed_slip(y - d, e).value) / (2 * d);
    EXPECT_NEAR(smoothed_slip(y, e).first_over_y * y, slope, 1e-9);
  }
  EXPECT_EQ(smoothed_slip(0, e).first_over_y, 2 / e);
}

TEST(ElasticSlip, IsASpringThatGivesWayAtCoulombsLimit) {
  constexpr double e = 0.3, d = 1e-6;
  for (const double y : {0.01, 0.1, 0.29, 0.31, 2.0}) {
    const double slope = (elastic_slip(y + d, e).value - elastic_slip(y - d, e).value) / (2 * d);
    EXPECT_NEAR(elastic_slip(y, e).first_over_y * y, slope, 1e-9);
    EXPECT_NEAR(slope, std::min(y / e, 1.0), 1e-9);
  }
  EXPECT_EQ(elastic_slip(0, e).first_over_y, 1 / e);
}

TEST(SmoothedSlip, MeetsCoulombsLawSmoothly) {
  constexpr double e = 0.3;
  const SmoothedSlip below = smoothed_slip(e * (1 - 1e-9), e), beyond = smoothed_slip(e, e);
  EXPECT_NEAR(below.value, beyond.value, 1e-9);
  EXPECT_NEAR(below.first_over_y, beyond.first_over_y, 1e-8);
  EXPECT_EQ(beyond.value, e);
  EXPECT_NEAR(beyond.first_over_y * e, 1, 1e-15);
}

}  // namespace
}  // namespace elastogen
