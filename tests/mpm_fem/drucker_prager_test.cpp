// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/materials/drucker_prager.hpp"

#include "core/constitutive.hpp"
#include "core/error.hpp"
#include "tests/mpm_fem/return_maps.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen {
namespace {

using test::Random;

std::string sand_message(const SandYield& yield) {
  try {
    drucker_prager<double>(test::plastic_solid(), yield);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

template <int d>
void sand_cone() {
  const auto law = drucker_prager<double, d>(test::plastic_solid(), test::kSand);
  const double alpha = cone_slope(test::kSand.friction), tip = d * d * law.bulk * law.cohesion;
  Random random(1);
  int cases[3] = {};  // tip, cone, inside
  for (int k = 0; k < 3000; ++k) {
    const HenckyStrain<double, d> e = test::random_strain<d>(0.1, random);
    const Returned<double> r = test::returned(law, e);
    const auto tau = test::parts<d>(r.tau);
    const auto after = split_strain<d>(r.e);
    const double y = tau.size + alpha * (tau.trace - tip);
    EXPECT_LT(y, 1e-15);
    const bool opens = e.trace > d * law.cohesion, slides = !opens && after.size < e.size;
    ++cases[opens ? 0 : slides ? 1 : 2];
    if (slides) {
      EXPECT_NEAR(y, 0, 1e-15);
    }
    EXPECT_NEAR(after.trace, opens ? d * law.cohesion : e.trace, 1e-15);
    if (opens) {
      EXPECT_NEAR(tau.trace, tip, 1e-15);
    }
  }
  for (const int count : cases) EXPECT_GT(count, 100);
}

TEST(DruckerPrager, FlowKeepsTheVolumeAndEndsOnTheCone) {
  sand_cone<2>();
  sand_cone<3>();
}

/// Mohr and Coulomb: with ratio (1 + sin)/(1 - sin) of the principal stresses the plane that slides
/// bears tan(friction) times its pressure.
TEST(DruckerPrager, TriaxialCompressionBearsTheTangentOfItsAngle) {
  for (const double friction : {0.3, 0.5, 0.7}) {
    const auto law = drucker_prager<double>(test::plastic_solid(), {.friction = friction});
    const double s[3] = {1.02, 1.02, 0.9};
    const Returned<double> r = test::returned(law, hencky_strain<3>(s));
    const double centre = -(r.tau[0] + r.tau[2]) / 2, radius = (r.tau[0] - r.tau[2]) / 2;
    const double sine = radius / centre;
    EXPECT_NEAR(sine / std::sqrt(1 - sine * sine), std::tan(friction), 1e-13);
  }
}

/// Sheared on and on at constant volume, principal stresses turn to 45 degrees: the plane of shear
/// bears the sine of the angle in the plane times its pressure, and the worst plane the tangent.
TEST(DruckerPrager, SteadyShearBearsTheSineOfTheAngleInThePlane) {
  const double friction = 0.5, sine = std::sqrt(2.0) * cone_slope(friction);
  const auto law = drucker_prager<double, 2>(test::plastic_solid(), {.friction = friction});
  EXPECT_NEAR(std::asin(std::sqrt(2.0) * cone_slope(std::numbers::pi / 6)) * 180 / std::numbers::pi,
              27.5, 0.05);
  // symmetric b = F F^T of the plane, turned and stretched by increments of shear
  double b[3] = {0.99 * 0.99, 0.99 * 0.99, 0};  // 00, 11, 01
  double shear = 0, pressure = 1;
  for (int k = 0; k < 4000; ++k) {
    const double g = 1e-3;
    const double next[3] = {b[0] + 2 * g * b[2] + g * g * b[1], b[1], b[2] + g * b[1]};
    const double mean = (next[0] + next[1]) / 2, half = (next[0] - next[1]) / 2;
    const double size = std::hypot(half, next[2]);
    double s[3] = {std::sqrt(mean + size), std::sqrt(mean - size), 1};
    const Returned<double> r = test::returned(law, hencky_strain<2>(s));
    const double c = half / size, t = next[2] / size;  // cosine, sine of twice the angle
    shear = (r.tau[0] - r.tau[1]) / 2 * t;
    pressure = -((r.tau[0] + r.tau[1]) / 2 - (r.tau[0] - r.tau[1]) / 2 * c);
    DruckerPrager<double, 2>::History history;
    law.commit(s, history);
    const double m = (s[0] * s[0] + s[1] * s[1]) / 2, h = (s[0] * s[0] - s[1] * s[1]) / 2;
    b[0] = m + h * c, b[1] = m - h * c, b[2] = h * t;
  }
  EXPECT_NEAR(shear / pressure, sine, 0.01);
}

/// Opened by 0.1 and closed again: a law that keeps the opening has no stress before it is closed.
TEST(DruckerPrager, WhatOpensHasToCloseBeforeItBears) {
  for (const bool keeps : {true, false}) {
    const auto law =
        drucker_prager<double>(test::plastic_solid(), {.friction = 0.5, .keeps_volume = keeps});
    DruckerPrager<double>::History history;
    double s[3] = {std::exp(0.05), std::exp(0.03), std::exp(0.02)};
    law.commit(s, history);
    for (const double x : s) EXPECT_NEAR(x, 1, 1e-15);
    EXPECT_NEAR(history.opening, keeps ? 0.1 : 0, 1e-15);
    for (int k = 0; k < 2; ++k) {
      for (double& x : s) x *= std::exp(-0.02);
      const Returned<double> r = test::returned(law, hencky_strain<3>(s), history);
      const double trace = -0.06 * (k + 1) + (keeps ? 0.1 : 0);
      EXPECT_NEAR(test::parts<3>(r.tau).trace, std::fmin(trace, 0) * 3 * law.bulk, 1e-14);
      law.commit(s, history);
      EXPECT_NEAR(history.opening, std::fmax(trace, 0) * keeps, 1e-15);
    }
    EXPECT_EQ(history.opening, 0);
  }
}

template <int d>
void sand_borders() {
  const auto law = drucker_prager<double, d>(test::plastic_solid(), test::kSand);
  Random random(2);
  const double tip = d * law.cohesion, trace = tip - 0.02;
  const double start = 0.02 * law.friction / (2 * law.mu);
  const double states[][2] = {{trace, 0},      {trace, start - 1e-6}, {trace, start + 1e-6},
                              {tip - 1e-6, 0}, {tip - 1e-6, 0.01},    {tip + 1e-6, 0.01},
                              {tip + 1e-6, 0}};
  for (const auto& [t, size] : states)
    for (int k = 0; k < 20; ++k) {
      const auto e = test::strain_along(test::random_strain<d>(0.1, random), t, size);
      EXPECT_LT(test::tangent_error(law, e, {}), 1e-7) << t << ' ' << size;
      EXPECT_LT(test::tangent_error(law, test::strain_along(e, t - 0.05, size), {0.05}), 1e-7);
    }
}

TEST(DruckerPrager, TangentIsRightOnBothSidesOfEveryBorder) {
  sand_borders<2>();
  sand_borders<3>();
}

TEST(DruckerPrager, TangentOnTheConeIsNotSymmetric) {
  const auto law = drucker_prager<double>(test::plastic_solid(), {.friction = 0.5});
  const double e[3] = {0.05, -0.02, -0.06};
  const Mat3<double> D = test::returned(law, split_strain<3>(e)).D;
  EXPECT_GT(std::abs(D(0, 2) - D(2, 0)), 0.1 * test::largest(D));
}

TEST(DruckerPrager, RejectsWhatIsNoSand) {
  EXPECT_EQ(sand_message({.friction = 1.6}),
            "the friction angle must lie in [0, pi/2), got 1.6 rad");
  EXPECT_EQ(sand_message({.friction = -0.1}),
            "the friction angle must lie in [0, pi/2), got -0.1 rad");
  EXPECT_EQ(sand_message({.cohesion = -1}), "the cohesion must not be negative, got -1");
  EXPECT_EQ(sand_message({}), "");
}

}  // namespace
}  // namespace elastogen
