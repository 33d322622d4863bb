// SPDX-License-Identifier: Apache-2.0
// A clamped beam of weight K = w L^3/(E I) = 11.772 at nu = 0 against the elastica and against the
// second-order terms in t/L that a solid adds to it.

#include "mpm_fem/integrators/static_fem.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

#include <array>

namespace elastogen::fem {
namespace {

using test::scene_of;
using test::solid;

constexpr double kLoad = 11.772;
constexpr double kElastica = 0.73832;  // deflection of the tip over L

/// M over EI kappa of a strip of the law mu sum (sigma - 1)^2, nu = 0, bent into an arc of
/// curvature kappa. Its fibres press on each other and sections thin: rho(y), the radius at which
/// the fibre y lies, makes E/2 int (kappa rho - 1)^2 + (rho' - 1)^2 dy least,
///
///     rho = 1/kappa + sinh(kappa y)/(kappa cosh(a)),    a = kappa t/2,
///     M = E/kappa int (kappa rho - 1)^2 dy = EI kappa (1 - 4/5 a^2 + ...).
double thinning(double a) {
  if (std::abs(a) < 1e-3) return 1 - 0.8 * a * a;
  return 1.5 / (a * a * a) * (std::sinh(2 * a) / 2 - a) / (std::cosh(a) * std::cosh(a));
}

/// The beam of length 1 by shooting: EI/EA = tau^2/12, EI/GA = tau^2/6 with shear factor 5/6.
struct Beam {
  double tau;  ///< t/L
  bool thins;

  double curvature(double moment) const {
    double kappa = moment;
    for (int k = 0; thins && k < 60; ++k) kappa = moment / thinning(kappa * tau / 2);
    return kappa;
  }
  /// Derivatives of angle, moment over EI and deflection at s; all that lies beyond s hangs there.
  std::array<double, 3> slope(double s, const std::array<double, 3>& y) const {
    const double q = kLoad * (1 - s), sine = std::sin(y[0]), cosine = std::cos(y[0]);
    const double stretch = 1 + tau * tau / 12 * q * sine, slip = tau * tau / 5 * q * cosine;
    return {curvature(y[1]), -q * (stretch * cosine - slip * sine), stretch * sine + slip * cosine};
  }
  /// Moment and deflection of the tip by Runge and Kutta's method.
  std::array<double, 2> shoot(double root_moment) const {
    constexpr int kSteps = 400;
    constexpr double kStep = 1.0 / kSteps;
    std::array<double, 3> y = {0, root_moment, 0};
    for (int n = 0; n < kSteps; ++n) {
      const auto ahead = [&](const std::array<double, 3>& k, double share) {
        std::array<double, 3> at = y;
        for (size_t i = 0; i < 3; ++i) at[i] += share * kStep * k[i];
        return at;
      };
      const double s = n * kStep;
      const auto k1 = slope(s, y), k2 = slope(s + kStep / 2, ahead(k1, 0.5));
      const auto k3 = slope(s + kStep / 2, ahead(k2, 0.5)), k4 = slope(s + kStep, ahead(k3, 1));
      for (size_t i = 0; i < 3; ++i) y[i] += kStep / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    }
    return {y[1], y[2]};
  }
  /// Deflection of the tip: the moment there is 0.
  double tip() const {
    double before = 4.1, now = 4.2, f = shoot(before)[0];
    for (int k = 0; k < 30 && std::abs(now - before) > 1e-12; ++k) {
      const double g = shoot(now)[0], next = now - g * (now - before) / (g - f);
      before = now, f = g, now = next;
    }
    return shoot(now)[1];
  }
};

/// Mean deflection of the end face of the solid over L, minus 1 times the elastica's.
double excess_of_solid(int slender, int across, Law law = Law::kFixedCorotated) {
  const double t = 1.0 / slender;
  FemScene scene =
      scene_of(test::block(Element::kTet10, slender * across, across, across, t / across),
               solid(law, 1000 * test::kGravity * 12 / (kLoad * t * t), 0));
  scene.gravity = {0, 0, -test::kGravity};
  test::clamp(scene, 0, 0);
  const StaticResult result = solve_static(scene, {.tolerance = 1e-8});
  EXPECT_TRUE(result.converged);
  return -test::plane_mean(scene, result.u, 0, 1, 2) / kElastica - 1;
}

TEST(Elastica, TheBeamOfNoThicknessIsTheElastica) {
  EXPECT_NEAR((Beam{1e-5, true}.tip()), kElastica, 1e-5);
}

TEST(Elastica, AConvergedSolidExceedsItByShearStretchAndThinning) {
  // shear and stretch alone: the bounds 1.1 and 0.3 % at L/t = 10 and 20 stand for them
  EXPECT_NEAR((Beam{0.1, false}.tip() / kElastica - 1), 0.01007, 5e-5);
  EXPECT_NEAR((Beam{0.05, false}.tip() / kElastica - 1), 0.00251, 5e-5);
  // two cells through the thickness are off by 3e-4 of the deflection at L/t = 10 and less beyond
  double missing[3], excess[3];
  for (int k = 0; k < 3; ++k) {
    const int slender = 10 << k;
    excess[k] = excess_of_solid(slender, 2);
    const double beam = Beam{1.0 / slender, true}.tip() / kElastica - 1;
    missing[k] = beam - excess[k];
    printf("L/t = %d: solid %+.3f %%, beam that shears, stretches and thins %+.3f %%\n", slender,
           100 * excess[k], 100 * beam);
  }
  // the difference falls faster than the second order: sections cannot thin at the clamp
  EXPECT_NEAR(excess[0], 0.0140, 3e-4);
  EXPECT_NEAR(excess[1], 0.00362, 1e-4);
  for (int k = 0; k < 2; ++k) {
    EXPECT_GT(missing[k], 0);
    EXPECT_GT(missing[k] / missing[k + 1], 5);
  }
  EXPECT_LT(missing[2], 5e-5);
  // four cells through the thickness; one is too stiff to show the thinning
  EXPECT_NEAR(excess_of_solid(10, 4), 0.0142, 1e-4);
  EXPECT_NEAR(excess_of_solid(20, 1), 0.0029, 1e-4);
  // without thickness: the solid is the elastica
  EXPECT_NEAR((4 * excess[2] - excess[1]) / 3, 0, 5e-5);
}

TEST(Elastica, EveryLawExceedsItByMoreThanShearAndStretch) {
  // at L/t = 10, where the strain at the root is 0.29, laws that agree for small strains differ
  const struct {
    Law law;
    double excess;
  } rows[] = {{Law::kNeoHookean, 0.0149},
              {Law::kStvk, 0.0169},
              {Law::kStableNeoHookean, 0.0179},
              {Law::kHencky, 0.0223}};
  for (const auto& [law, excess] : rows) {
    const double measured = excess_of_solid(10, 2, law);
    printf("%s: %+.3f %%\n", law_name(law).c_str(), 100 * measured);
    EXPECT_NEAR(measured, excess, 3e-4);
  }
}

}  // namespace
}  // namespace elastogen::fem
