// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/materials/von_mises.hpp"

#include "core/error.hpp"
#include "tests/mpm_fem/return_maps.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::Random;

std::string metal_message(const Material& material, const MetalYield& yield) {
  try {
    von_mises<double>(material, yield);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// The stress of a bar that is pulled to log strain `most` in steps, free at its sides.
template <int d, class Law>
double pulled_bar(const Law& law, double most, int steps) {
  double s[3] = {1, 1, 1};
  typename Law::History history;
  double stress = 0;
  for (int k = 0; k < steps; ++k) {
    s[0] *= std::exp(most / steps);
    // the sides move until they bear nothing
    for (int n = 0; n < 50; ++n) {
      const Returned<double> r = test::returned(law, hencky_strain<d>(s), history);
      double slope = 0;
      for (int j = 1; j < d; ++j) slope += r.D(1, j);
      for (int j = 1; j < d; ++j) s[j] *= std::exp(-r.tau[1] / slope);
      stress = r.tau[0];
    }
    law.commit(s, history);
  }
  return stress;
}

/// sigma_Y + H eps_p with eps_p the strain but for sigma/E_d.
template <int d>
void metal_bar() {
  const double modulus = d == 3 ? 1 : 1 / (1 - 0.09), yield = 0.02, H = 0.1;
  const auto law = von_mises<double, d>(test::plastic_solid(), {yield, H});
  const double below = 0.9 * yield / modulus, above = 4 * yield / modulus;
  EXPECT_NEAR((pulled_bar<d>(law, below, 3)), 0.9 * yield, 1e-13);
  const double stress = yield + modulus * H / (modulus + H) * (above - yield / modulus);
  for (const int steps : {1, 2, 7})
    EXPECT_NEAR((pulled_bar<d>(law, above, steps)), stress, 1e-13) << steps;
  EXPECT_NEAR(stress, yield + H * (above - stress / modulus), 1e-13);
  EXPECT_NEAR((pulled_bar<d>(von_mises<double, d>(test::plastic_solid(), {yield, 0}), above, 3)),
              yield, 1e-13);
}

TEST(VonMises, ABarYieldsAtItsStressAndHardensWithItsSlope) {
  metal_bar<2>();
  metal_bar<3>();
}

template <int d>
void metal_surface() {
  const auto law = von_mises<double, d>(test::plastic_solid(), test::kMetal);
  Random random(1);
  int flowed = 0;
  for (int k = 0; k < 3000; ++k) {
    const HenckyStrain<double, d> e = test::random_strain<d>(0.1, random);
    const Returned<double> r = test::returned(law, e, {0.02});
    const HenckyStrain<double, d> after = split_strain<d>(r.e);
    const double flow = e.size - after.size, limit = law.radius + law.hardening * (0.02 + flow);
    EXPECT_NEAR(after.trace, e.trace, 1e-16);
    const double stress = test::parts<d>(r.tau).size;
    EXPECT_LE(stress, limit + 1e-15);
    if (flow > 0) {
      EXPECT_NEAR(stress, limit, 1e-15);
    }
    flowed += flow > 0;
  }
  EXPECT_GT(flowed, 1000);
  EXPECT_LT(flowed, 3000);
}

TEST(VonMises, FlowKeepsTheVolumeAndEndsOnTheGrownSurface) {
  metal_surface<2>();
  metal_surface<3>();
}

/// Li, Li, Jiang 2022 (ECI): mu a^2, beyond a_Y = radius/(2 mu) the tangent's parabola.
template <int d>
void metal_potential() {
  const auto law = von_mises<double, d>(test::plastic_solid(), test::kMetal);
  const double mu = law.mu, H = law.hardening, start = law.radius / (2 * mu);
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const HenckyStrain<double, d> e = test::random_strain<d>(0.1, random);
    const double x = e.size - start;
    const double shear = x < 0
                             ? mu * e.size * e.size
                             : mu * start * start + law.radius * x + mu * H / (2 * mu + H) * x * x;
    const Returned<double> r = test::returned(law, e);
    EXPECT_NEAR(r.psi, law.bulk / 2 * e.trace * e.trace + shear, 1e-16);
    EXPECT_LT(test::gradient_error(law, e), 1e-9);
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < d; ++j) EXPECT_NEAR(r.D(i, j), r.D(j, i), 1e-15);
  }
}

TEST(VonMises, StressIsTheGradientOfThePublishedPotential) {
  metal_potential<2>();
  metal_potential<3>();
}

template <int d>
void metal_borders() {
  const auto law = von_mises<double, d>(test::plastic_solid(), test::kMetal);
  Random random(3);
  const double start = law.radius / (2 * law.mu);
  for (const double size : {0.0, start - 1e-6, start + 1e-6})
    for (int k = 0; k < 20; ++k) {
      const auto e = test::strain_along(test::random_strain<d>(0.1, random), 0.03, size);
      EXPECT_LT(test::tangent_error(law, e), 1e-8) << size;
    }
}

TEST(VonMises, TangentIsRightOnBothSidesOfYield) {
  metal_borders<2>();
  metal_borders<3>();
}

TEST(VonMises, BelowYieldItIsHenckysLaw) {
  const auto law = von_mises<double>(test::plastic_solid(), {.stress = 1e9});
  const LawParameters<double> hencky = {Law::kHencky, test::plastic_solid().mu(),
                                        test::plastic_solid().lambda()};
  for (const double least : {0.8, 0.05, -0.2}) {
    const double s[3] = {1.3, 1.1, least};
    const Response<double> r = law.response<true>(s, {}), exact = elastic_response<true>(hencky, s);
    EXPECT_NEAR(r.psi, exact.psi, 1e-13 * exact.psi);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(r.t[i], exact.t[i], 1e-12 * std::abs(exact.t[2]));
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(r.H[i], exact.H[i], 1e-12 * std::abs(exact.H[2]));
  }
}

/// Sheared on and on at constant volume it bears sigma_Y/sqrt(3), in two dimensions sigma_Y/2.
TEST(VonMises, ShearBearsTheStressOfABarOverRootThree) {
  const auto law = von_mises<double>(test::plastic_solid(), {.stress = 0.02});
  const auto flat = von_mises<double, 2>(test::plastic_solid(), {.stress = 0.02});
  const double s[3] = {1.25, 0.8, 1};
  const Returned<double> r = test::returned(law, hencky_strain<3>(s)),
                         f = test::returned(flat, hencky_strain<2>(s));
  EXPECT_NEAR((r.tau[0] - r.tau[1]) / 2, 0.02 / std::sqrt(3.0), 1e-15);
  EXPECT_NEAR((f.tau[0] - f.tau[1]) / 2, 0.02 / 2, 1e-15);
}

/// Flow fills the third direction, where plane strain as a whole has none; in two dimensions it has
/// no place to.
TEST(VonMises, PlaneStrainIsTheLawInThreeDimensionsAndIntrinsicTwoIsNot) {
  const auto law = von_mises<double>(test::plastic_solid(), {.stress = 0.02});
  double s[3] = {1.2, 0.9, 1};
  VonMises<double>::History history;
  law.commit(s, history);
  EXPECT_GT(std::abs(s[2] - 1), 1e-3);
  EXPECT_NEAR(s[0] * s[1] * s[2], 1.2 * 0.9, 1e-15);
  double flat[3] = {1.2, 0.9, 1};
  VonMises<double, 2>::History flow;
  von_mises<double, 2>(test::plastic_solid(), {.stress = 0.02}).commit(flat, flow);
  EXPECT_EQ(flat[2], 1);
  EXPECT_NEAR(flat[0] * flat[1], 1.2 * 0.9, 1e-15);
}

TEST(VonMises, RejectsWhatIsNoMetal) {
  EXPECT_EQ(metal_message(test::plastic_solid(), {.stress = 0}),
            "the yield stress must be positive, got 0 Pa");
  EXPECT_EQ(metal_message(test::plastic_solid(), {.stress = 1, .hardening = -2}),
            "the hardening must not be negative, got -2 Pa");
  Material soft = test::plastic_solid();
  soft.young = -1;
  EXPECT_NE(metal_message(soft, {}).find("Young's modulus must be positive"), std::string::npos);
  EXPECT_EQ(metal_message(test::plastic_solid(), {}), "");
}

}  // namespace
}  // namespace elastogen
