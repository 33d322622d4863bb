// SPDX-License-Identifier: Apache-2.0
// Laws by Green's strain against the same laws by singular values.

#include "core/strain_law.hpp"

#include "tests/support/laws.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace elastogen {
namespace {

using test::Random;

constexpr Law::Kind kKinds[] = {Law::Kind::kStvk, Law::Kind::kNeoHookean,
                                Law::Kind::kStableNeoHookean};

Mat3<double> minus_identity(Mat3<double> F) {
  for (int i = 0; i < 3; ++i) F(i, i) -= 1;
  return F;
}

/// A random F with stretches in 0.45 ... 2.4.
Mat3<double> random_gradient(Random& random) {
  std::uniform_real_distribution<double> stretch(0.45, 2.4);
  const double a = stretch(random), b = stretch(random), c = stretch(random);
  return test::stretched(a, b, c, random);
}

TEST(StrainLaw, IsTheLawInStretches) {
  Random random(1);
  for (const Law::Kind kind : kKinds)
    for (const double poisson : {0.0, 0.3, 0.495}) {
      const auto law = test::parameters<double>(Law{kind}, 1, poisson);
      ASSERT_TRUE(is_law_of_strain(law.law));
      int compared = 0;
      for (int k = 0; k < 3000; ++k) {
        const Mat3<double> F = random_gradient(random);
        StrainResponse<double> found;
        if (!strain_response(law, minus_identity(F), found)) continue;
        ++compared;
        const test::Point<double> p = test::point(law, F);
        const double size = 1 + law.lambda, eps = 1e-13 * size;
        ASSERT_NEAR(found.psi, p.r.psi, eps * (1 + p.r.psi / size)) << law_name(law.law);
        ASSERT_NEAR(found.J, determinant(F), 1e-14 * (1 + found.J));
        ASSERT_LT(test::distance(found.P, p.P), eps + 1e-12 * test::norm(p.P)) << law_name(law.law);
      }
      EXPECT_GT(compared, 2000);
    }
}

TEST(StrainLaw, StressIsTheDerivativeOfTheEnergy) {
  Random random(2);
  constexpr double d = 1e-6;
  for (const Law::Kind kind : kKinds) {
    const auto law = test::parameters<double>(Law{kind}, 1, 0.4);
    for (int k = 0; k < 200; ++k) {
      const Mat3<double> H = minus_identity(test::stretched(1.5, 1.1, 0.6, random));
      StrainResponse<double> at, up, down;
      ASSERT_TRUE(strain_response(law, H, at));
      for (int m = 0; m < 9; ++m) {
        Mat3<double> above = H, below = H;
        above.m[m] += d, below.m[m] -= d;
        ASSERT_TRUE(strain_response(law, above, up) && strain_response(law, below, down));
        ASSERT_NEAR(at.P.m[m], (up.psi - down.psi) / (2 * d), 1e-8) << law_name(law.law);
      }
    }
  }
}

/// Float keeps the digits that E has: energies are right to eps |E| and not to eps alone, of turned
/// bodies too; stresses to eps, or eps |E| where nothing turns.
TEST(StrainLaw, KeepsTheDigitsOfSmallStrains) {
  Random random(3);
  constexpr double kEps = std::numeric_limits<float>::epsilon();
  for (const Law::Kind kind : kKinds) {
    const auto law = test::parameters<double>(Law{kind}, 1, 0.4);
    const auto low = test::parameters<float>(Law{kind}, 1, 0.4);
    for (const double e : {1e-2, 1e-3, 1e-4})
      for (const bool turned : {false, true})
        for (int k = 0; k < 300; ++k) {
          const Mat3<double> V = test::rotation(random);
          Mat3<double> H{};
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) H(i, j) = e * (V(i, 0) * V(j, 0) - 0.5 * V(i, 1) * V(j, 1));
          if (turned) {
            Mat3<double> F = H;
            for (int i = 0; i < 3; ++i) F(i, i) += 1;
            H = minus_identity(test::rotation(random) * F);
          }
          const Mat3<float> given = test::cast<float>(H);
          StrainResponse<float> found;
          StrainResponse<double> exact;
          ASSERT_TRUE(strain_response(low, given, found));
          ASSERT_TRUE(strain_response(law, test::cast<double>(given), exact));
          ASSERT_NEAR(found.psi, exact.psi, 4 * kEps * e) << law_name(law.law);
          // H has numbers of 1 where the body is turned, of e where not
          const double noise = 20 * kEps * (turned ? 1 : e);
          ASSERT_LT(test::distance(test::cast<double>(found.P), exact.P), noise);
        }
  }
}

TEST(StrainLaw, LeavesFarStatesAndOtherLawsToTheStretches) {
  Random random(4);
  StrainResponse<double> ignored;
  for (const Law::Kind kind : kKinds) {
    const auto law = test::parameters<double>(Law{kind}, 1, 0.3);
    const auto takes = [&](double a, double b, double c) {
      return strain_response(law, minus_identity(test::stretched(a, b, c, random)), ignored);
    };
    EXPECT_TRUE(takes(1, 1, 1) && takes(2.5, 0.9, 0.6) && takes(0.75, 0.75, 0.75));
    EXPECT_FALSE(takes(1, 1, -1));
    EXPECT_FALSE(takes(-1, -1, -1));
    EXPECT_FALSE(takes(3.1, 1, 1));
    EXPECT_FALSE(takes(1, 1, 0.4));
    EXPECT_FALSE(takes(0, 0, 0));
    EXPECT_FALSE(takes(NAN, 1, 1));
  }
  for (const Law law : {Law{Law::Kind::kFixedCorotated}, Law{Law::Kind::kHencky}})
    EXPECT_FALSE(is_law_of_strain(law));
}

TEST(StrainLaw, ARowGoesByStrainOnlyAsAWhole) {
  Random random(5);
  using P = Pack<float>;
  for (const Law::Kind kind : kKinds) {
    const auto law = test::parameters<float>(Law{kind}, 1, 0.3);
    Mat3<P> H{};
    Mat3<float> lanes[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
      lanes[lane] = test::cast<float>(minus_identity(test::stretched(1.4, 1, 0.8, random)));
      for (int m = 0; m < 9; ++m) H.m[m][lane] = lanes[lane].m[m];
    }
    StrainResponse<P> row;
    ASSERT_TRUE(strain_response(law, H, row));
    for (int lane = 0; lane < kLanes; ++lane) {
      StrainResponse<float> one;
      ASSERT_TRUE(strain_response(law, lanes[lane], one));
      EXPECT_NEAR(row.psi[lane], one.psi, 1e-6);
      EXPECT_NEAR(row.J[lane], one.J, 1e-6);
      for (int m = 0; m < 9; ++m) EXPECT_NEAR(row.P.m[m][lane], one.P.m[m], 1e-5);
    }
    H(0, 0)[3] = 3;
    EXPECT_FALSE(strain_response(law, H, row));
  }
}

}  // namespace
}  // namespace elastogen
