// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "mpm_fem/materials/cam_clay_map.hpp"
#include "tests/mpm_fem/return_maps.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::kSnow;
using test::Random;

std::string snow_message(const SnowYield& yield) {
  try {
    cam_clay<double>(test::plastic_solid(), yield);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// (1 + 2 beta) q^2 + M^2 (p + beta p0)(p - p0) over the largest of the second term.
template <int d>
double snow_yield(const double tau[3], double p0) {
  const auto parts = test::parts<d>(tau);
  const double p = -parts.trace / d, half = (1 + kSnow.cohesion) * p0 / 2;
  const double q2 = (6 - d) / 2.0 * parts.size * parts.size;
  return ((1 + 2 * kSnow.cohesion) * q2 +
          kSnow.slope * kSnow.slope * (p + kSnow.cohesion * p0) * (p - p0)) /
         (kSnow.slope * kSnow.slope * half * half);
}

/// Beside the tips J stays and the point is on the ellipse, for large strains too.
template <int d>
void snow_ellipse() {
  const auto law = cam_clay<double, d>(test::plastic_solid(), kSnow);
  Random random(1);
  int cases[3] = {};  // tip, side, inside
  for (int k = 0; k < 10000; ++k) {
    const auto e = test::random_strain<d>(k % 2 ? 0.1 : 0.02, random);
    const Returned<double> r = test::returned(law, e);
    const auto y = law.ellipse({});
    const double value = snow_yield<d>(r.tau, kSnow.pressure);
    EXPECT_LT(value, 1e-13);
    const bool tip = e.trace < y.compressed || e.trace > y.opened;
    const bool side = !tip && test::distance<d>(r.e, e.e) > 0;
    ++cases[tip ? 0 : side ? 1 : 2];
    if (!tip) {
      EXPECT_NEAR(split_strain<d>(r.e).trace, e.trace, 1e-15);
    }
    if (tip || side) {
      EXPECT_NEAR(value, 0, 1e-13);
    }
  }
  for (const int count : cases) EXPECT_GT(count, 300);
}

TEST(CamClay, ShearFallsToTheEllipseAndKeepsTheVolume) {
  snow_ellipse<2>();
  snow_ellipse<3>();
}

TEST(CamClay, StressInsideIsTheGradientOfTheEnergy) {
  const auto flat = cam_clay<double, 2>(test::plastic_solid(), kSnow);
  const auto law = cam_clay<double>(test::plastic_solid(), kSnow);
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    EXPECT_LT(test::gradient_error(flat, test::random_strain<2>(0.003, random)), 1e-10);
    EXPECT_LT(test::gradient_error(law, test::random_strain<3>(0.003, random)), 1e-10);
  }
}

/// p = -k (J^2 - 1)/2 up to p0; beyond, p0 = k (1e-5 + sinh(-xi a)) with a fallen by ln J - ln J_e;
/// unloading is elastic from the J_e that is left.
TEST(CamClay, PressedAndReleasedItFollowsTheClosedForm) {
  const auto law = cam_clay<double>(test::plastic_solid(), kSnow);
  const double bulk = law.bulk, start = -std::asinh(kSnow.pressure / bulk - 1e-5);
  CamClay<double>::History history;
  double s[3] = {1, 1, 1}, a = start, trace = 0;  // trace: ln J of the elastic part
  for (int k = 0; k < 30; ++k) {
    const double step = k < 20 ? -0.01 : 0.005;
    for (double& x : s) x *= std::exp(step / 3);
    trace += step;
    const double p0 = bulk * (1e-5 + std::sinh(-a)), tip = std::log(1 - 2 * p0 / bulk) / 2;
    const double expected = std::fmin(-bulk / 2 * (std::exp(2 * trace) - 1), p0);
    const Returned<double> r = test::returned(law, hencky_strain<3>(s), history);
    for (const double t : r.tau) EXPECT_NEAR(t, -expected, 1e-14) << k;
    if (trace < tip) a += trace - tip, trace = tip;
    law.commit(s, history);
    EXPECT_NEAR(history.compaction, a - start, 1e-14) << k;
    EXPECT_NEAR(std::log(s[0] * s[1] * s[2]), trace, 1e-14) << k;
  }
  EXPECT_LT(a, start - 0.02);
}

TEST(CamClay, TornApartItBearsItsTensileStrengthAndSoftens) {
  const auto law = cam_clay<double>(test::plastic_solid(), kSnow);
  double s[3] = {1.2, 1.1, 1.15};
  const Returned<double> r = test::returned(law, hencky_strain<3>(s));
  for (const double t : r.tau) EXPECT_NEAR(t, kSnow.cohesion * kSnow.pressure, 1e-15);
  CamClay<double>::History history;
  law.commit(s, history);
  EXPECT_GT(history.compaction, 0.1);
  EXPECT_NEAR(law.ellipse(history).pressure, 1e-5 * law.bulk, 1e-12);  // nothing is left of it
}

/// Sheared, snow hardens at pressures above the ellipse's centre, softens below, and stays at it.
template <int d>
void sheared_snow() {
  const auto law = cam_clay<double, d>(test::plastic_solid(), kSnow);
  Random random(3);
  const double centre = kSnow.pressure * (1 - kSnow.cohesion) / 2;
  for (const double away : {-0.01, 0.0, 0.01}) {
    const double trace = std::log(1 - 2 * (centre + away) / law.bulk) / 2;
    const auto e = test::strain_along(test::random_strain<d>(0.1, random), trace, 0.2);
    const double change = law.compaction(e, {});
    if (away == 0) {
      EXPECT_NEAR(change, 0, 1e-16);
    } else {
      EXPECT_LT(change * away, 0);
    }
    // the point (p, q) after this change lies on the ellipse, on the line to its centre
    const double p = law.bulk / 2 * (1 - std::exp(2 * (trace - change)));
    const double part = away == 0 ? 0 : (p - centre) / away;
    EXPECT_LT(part, 1);
    const double q = part * std::sqrt((6 - d) / 2.0) * snow_shear(e, law.mu).size;
    if (away != 0) {
      const double half = kSnow.pressure * (1 + kSnow.cohesion) / 2, M = kSnow.slope;
      EXPECT_NEAR((1 + 2 * kSnow.cohesion) * q * q + M * M * (p - centre) * (p - centre),
                  M * M * half * half, 1e-15);
    }
  }
}

TEST(CamClay, ShearHardensOrSoftensBesideTheCriticalState) {
  sheared_snow<2>();
  sheared_snow<3>();
}

TEST(CamClay, DensestSnowIsHalfWayToWhatTheElasticityBears) {
  const auto law = cam_clay<double>(test::plastic_solid(), kSnow);
  const auto y = law.ellipse({-1e3});
  EXPECT_NEAR(y.pressure, 0.45001 * law.bulk, 1e-6);
  EXPECT_TRUE(std::isfinite(y.compressed));
}

template <int d>
void snow_borders() {
  const auto law = cam_clay<double, d>(test::plastic_solid(), kSnow);
  const auto y = law.ellipse({});
  Random random(4);
  for (const double trace : {y.compressed / 2, 0.0, y.opened / 2}) {
    const auto along = test::strain_along(test::random_strain<d>(0.1, random), trace, 0.1);
    const auto excess = [&](double size) {
      const auto e = test::strain_along(along, trace, size);
      return ValueAndSlope<double>{snow_shear(e, law.mu).size - law.radius(y, trace).value,
                                   2 * law.mu};
    };
    const double border = increasing_root(excess, 0.0, 0.1, 0.05);
    for (const double size : {0.0, border - 1e-6, border + 1e-6, 0.3})
      EXPECT_LT(test::tangent_error(law, test::strain_along(along, trace, size)), 1e-7) << size;
  }
  // near the tips the ellipse is steep
  for (const double trace :
       {y.compressed - 1e-6, y.compressed + 1e-4, y.opened - 1e-4, y.opened + 1e-6})
    for (const double size : {0.0, 0.05}) {
      const auto e = test::strain_along(test::random_strain<d>(0.1, random), trace, size);
      EXPECT_LT(test::tangent_error(law, e), 1e-6) << trace << ' ' << size;
    }
}

TEST(CamClay, TangentIsRightOnBothSidesOfEveryBorder) {
  snow_borders<2>();
  snow_borders<3>();
}

TEST(CamClay, RejectsWhatIsNoSnow) {
  EXPECT_EQ(snow_message({.slope = 0}), "the slope of the critical state must be positive, got 0");
  EXPECT_EQ(snow_message({.cohesion = -1}), "the cohesion must not be negative, got -1");
  EXPECT_EQ(snow_message({.hardening = 0}), "the hardening must be positive, got 0");
  EXPECT_NE(snow_message({.pressure = 0.4}).find("the yield pressure must lie between "),
            std::string::npos);
  EXPECT_NE(snow_message({.pressure = 0}).find(" Pa, got 0"), std::string::npos);
  EXPECT_EQ(snow_message(kSnow), "");
}

}  // namespace
}  // namespace elastogen
