// SPDX-License-Identifier: Apache-2.0
// The five laws through the decomposition of F: stress and Hessian.

#include "core/principal.hpp"

#include "tests/support/eigenvalues.hpp"
#include "tests/support/laws.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace elastogen {
namespace {

using test::kLaws;
using test::parameters;
using test::point;
using test::Point;
using test::Random;

Mat3<double> plus(Mat3<double> A, double factor, const Mat3<double>& B) {
  for (int k = 0; k < 9; ++k) A.m[k] += factor * B.m[k];
  return A;
}

double contract(const Mat3<double>& A, const Mat3<double>& B) {
  double sum = 0;
  for (int k = 0; k < 9; ++k) sum += A.m[k] * B.m[k];
  return sum;
}

/// The 9x9 matrix of a Hessian, by unit directions.
Eigen::MatrixXd matrix(const PrincipalHessian<double>& h, const Svd3<double>& F) {
  Eigen::MatrixXd result(9, 9);
  for (int col = 0; col < 9; ++col) {
    Mat3<double> unit{};
    unit.m[col] = 1;
    const Mat3<double> column = apply(h, F, unit);
    for (int row = 0; row < 9; ++row) result(row, col) = column.m[row];
  }
  return result;
}

TEST(Principal, RotationsAreFreeOfEnergyAndStress) {
  Random random(1);
  for (const Law kind : kLaws) {
    const auto law = parameters<double>(kind, 1, 0.3);
    const auto low = parameters<float>(kind, 1, 0.3);
    double energy = 0, stress = 0, low_stress = 0;
    for (int k = 0; k < 20000; ++k) {
      const double angle = k % 3 == 0 ? 1e-8 : std::numbers::pi - 1e-8;
      const Mat3<double> R = k % 3 == 1 ? test::rotation(random) : test::rotation_by(angle, random);
      const Point<double> p = point(law, R);
      energy = std::max(energy, std::abs(p.r.psi));
      stress = std::max(stress, test::norm(p.P));
      low_stress = std::max(low_stress, double(test::norm(point(low, test::cast<float>(R)).P)));
    }
    EXPECT_LE(energy, 1e-15) << law_name(kind);
    EXPECT_LE(stress, 1e-13) << law_name(kind);
    EXPECT_LE(low_stress, 1e-5) << law_name(kind);
  }
}

TEST(Principal, LawsAreObjectiveAndIsotropic) {
  Random random(2);
  for (const Law kind : kLaws) {
    const auto law = parameters<double>(kind, 1, 0.4);
    for (int k = 0; k < 1000; ++k) {
      const Mat3<double> F = test::stretched(1.5, 1.1, k % 4 ? 0.4 : -0.4, random);
      const Mat3<double> Q = test::rotation(random);
      const Point<double> p = point(law, F), turned = point(law, Q * F);
      const double size = 1e-12 * (1 + test::norm(p.P));
      ASSERT_NEAR(turned.r.psi, p.r.psi, size) << law_name(kind);
      ASSERT_LT(test::distance(turned.P, Q * p.P), size) << law_name(kind);
      const Point<double> other = point(law, F * Q);
      ASSERT_NEAR(other.r.psi, p.r.psi, size) << law_name(kind);
      ASSERT_LT(test::distance(other.P, p.P * Q), size) << law_name(kind);
      const Mat3<double> kirchhoff = times_transposed(p.P, F);
      for (int i = 0; i < 3; ++i)
        ASSERT_NEAR(kirchhoff(i, (i + 1) % 3), kirchhoff((i + 1) % 3, i), size) << law_name(kind);
    }
  }
}

/// Remainders of psi and P along a direction, relative to the terms that are kept.
struct Remainder {
  double psi, P;
};

Remainder remainder(const LawParameters<double>& law, const Mat3<double>& F, const Mat3<double>& dF,
                    double step) {
  const Point<double> here = point(law, F), there = point(law, plus(F, step, dF));
  const Mat3<double> dP = apply(here.hessian, here.svd, dF);
  const double slope = contract(here.P, dF);
  return {std::abs(there.r.psi - here.r.psi - step * slope),
          test::distance(there.P, plus(here.P, step, dP))};
}

TEST(Principal, StressAndHessianPassTheTaylorTest) {
  Random random(3);
  for (const Law kind : kLaws) {
    const auto law = parameters<double>(kind, 1, 0.4);
    for (const double sign : {1.0, -1.0}) {
      Remainder coarse{}, middle{}, fine{};
      double best = 0;
      // remainders of Taylor's formula, summed over random states and directions
      for (int k = 0; k < 200; ++k) {
        const Mat3<double> F = test::stretched(1.6, 1.0, sign * 0.6, random);
        const Mat3<double> dF = test::gaussian(random);
        const auto add = [&](Remainder& to, double step) {
          const Remainder r = remainder(law, F, dF, step);
          to.psi += r.psi, to.P += r.P;
        };
        add(coarse, 1e-3), add(middle, 1e-4), add(fine, 1e-5);
        best = std::max(best, remainder(law, F, dF, 1e-6).P / test::norm(point(law, F).P));
      }
      // both fall with the square of the step, down to rounding
      SCOPED_TRACE(law_name(kind));
      EXPECT_NEAR(std::log10(coarse.psi / middle.psi), 2, 0.1);
      EXPECT_NEAR(std::log10(middle.psi / fine.psi), 2, 0.1);
      EXPECT_NEAR(std::log10(coarse.P / middle.P), 2, 0.1);
      EXPECT_NEAR(std::log10(middle.P / fine.P), 2, 0.1);
      EXPECT_LE(best, 1e-8);
    }
  }
}

TEST(Principal, SmallStrainStiffnessIsLinearElasticity) {
  constexpr double d = 1e-6;
  for (const Law kind : kLaws) {
    const auto law = parameters<double>(kind, 1, 0.3);
    Mat3<double> up = identity<double>(), down = up, shear = up;
    up(0, 0) += d, down(0, 0) -= d, shear(0, 1) += d;
    const Mat3<double> P = point(law, up).P, N = point(law, down).P;
    EXPECT_NEAR((P(0, 0) - N(0, 0)) / (2 * d), law.lambda + 2 * law.mu, 1e-6) << law_name(kind);
    EXPECT_NEAR((P(1, 1) - N(1, 1)) / (2 * d), law.lambda, 1e-6) << law_name(kind);
    EXPECT_NEAR(point(law, shear).P(0, 1) / d, law.mu, 2e-6) << law_name(kind);
    EXPECT_NEAR(point(law, shear).P(1, 0) / d, law.mu, 2e-6) << law_name(kind);
  }
}

TEST(Principal, SimpleShearIsThatOfTheTable) {
  const std::pair<Law, double> table[] = {{Law::kFixedCorotated, 0.425220},
                                          {Law::kNeoHookean, 0.384615},
                                          {Law::kStableNeoHookean, 0.410256},
                                          {Law::kStvk, 1.057692},
                                          {Law::kHencky, 0.331084},
                                          {Law::ogden(2), 0.384615},  // mu: J is 1
                                          {Law::mooney_rivlin(0.3), 0.384615},
                                          {Law::gent(20), 0.384615 * 20 / 19}};
  for (const auto& [kind, stress] : table) {
    Mat3<double> F = identity<double>();
    F(0, 1) = 1;
    const Point<double> p = point(parameters<double>(kind, 1, 0.3), F);
    EXPECT_NEAR(times_transposed(p.P, F)(0, 1), stress, 1e-6) << law_name(kind);
  }
}

TEST(Principal, PositivePartIsTheClampOfTheNineEigenvalues) {
  Random random(4);
  for (const Law kind : kLaws) {
    const auto law = parameters<double>(kind, 1, 0.45);
    int changed = 0;
    for (int k = 0; k < 150; ++k) {
      const Mat3<double> F =
          k % 3 ? test::gaussian(random) : test::stretched_within(0.2, 0.9, random);
      const Point<double> p = point(law, F);
      const Eigen::MatrixXd raw = matrix(p.hessian, p.svd);
      const Eigen::MatrixXd projected = matrix(positive_part(p.hessian), p.svd);
      const double size = raw.norm();
      ASSERT_LE((projected - test::clamped(raw)).norm(), 1e-12 * size) << law_name(kind);
      ASSERT_GE(test::eigenvalues(projected)(0), -1e-13 * size) << law_name(kind);
      changed += (projected - raw).norm() > 1e-6 * size;
    }
    EXPECT_GT(changed, 10) << law_name(kind) << ": the samples must have indefinite ones";
  }
}

TEST(Principal, PositivePartLeavesADefiniteHessianUntouched) {
  Random random(5);
  for (const Law kind : kLaws) {
    const auto law = parameters<double>(kind, 1, 0.3);
    for (int k = 0; k < 200; ++k) {
      const Point<double> p = point(law, test::stretched_within(1.01, 1.06, random));
      const PrincipalHessian<double> positive = positive_part(p.hessian);
      for (int i = 0; i < 6; ++i) ASSERT_EQ(positive.A.m[i], p.hessian.A.m[i]);
      for (int i = 0; i < 3; ++i) {
        ASSERT_EQ(positive.twist[i], p.hessian.twist[i]);
        ASSERT_EQ(positive.flip[i], p.hessian.flip[i]);
      }
    }
  }
}

TEST(Principal, FlipIsContinuousWhereStretchesMeet) {
  for (const Law kind : kLaws) {
    const auto law = parameters<double>(kind, 1, 0.4);
    const auto low = parameters<float>(kind, 1, 0.4);
    const auto flip = [](const auto& moduli, auto gap) {
      using S = decltype(gap);
      const S s[3] = {S(1.2) + gap, S(1.2), S(0.7)};
      return double(principal_hessian(s, elastic_response<true>(moduli, s)).flip[0]);
    };
    const double limit = flip(law, 0.0);
    for (const double gap : {1e-15, 1e-9, 2.3e-6, 2.5e-6, 1e-5, 1e-3})
      EXPECT_NEAR(flip(law, gap), limit, 5 * gap + 1e-8) << law_name(kind) << gap;
    for (const float gap : {1e-6f, 1e-4f, 2.3e-3f, 2.5e-3f})
      EXPECT_NEAR(flip(low, gap), limit, 5 * gap + 1e-3) << law_name(kind) << gap;
  }
}

template <class S>
void expect_finite(Law kind, const Mat3<S>& F) {
  const Point<S> p = point(parameters<S>(kind, 1, 0.45), F);
  const PrincipalHessian<S> h = positive_part(p.hessian);
  ASSERT_TRUE(std::isfinite(p.r.psi)) << law_name(kind);
  for (const S entry : p.P.m) ASSERT_TRUE(std::isfinite(entry)) << law_name(kind);
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(std::isfinite(h.A.m[i])) << law_name(kind);
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(std::isfinite(h.twist[i]) && std::isfinite(h.flip[i])) << law_name(kind);
}

TEST(Principal, EveryStateHasFiniteEnergyStressAndHessian) {
  Random random(6);
  for (const test::Family& family : test::kFamilies) {
    SCOPED_TRACE(family.name);
    for (int k = 0; k < 2000; ++k) {
      Mat3<double> F = family.draw(random);
      const double size = test::norm(F);
      if (size > 100) F = test::scaled(F, 100 / size);
      for (const Law kind : kLaws) {
        expect_finite(kind, F);
        expect_finite(kind, test::cast<float>(F));
      }
    }
  }
}

TEST(Principal, PacksOfFloatAgreeWithDouble) {
  Random random(7);
  for (const Law kind : kLaws) {
    const auto low = parameters<float>(kind, 1, 0.4);
    const LawParameters<double> high{kind, low.mu, low.lambda};
    // a pack of different states, with one direction in all lanes
    for (int k = 0; k < 300; ++k) {
      Mat3<float> F[kLanes];
      for (Mat3<float>& f : F) f = test::cast<float>(test::stretched_within(0.6, 1.5, random));
      const Mat3<float> dF = test::cast<float>(test::gaussian(random));
      Mat3<float> same[kLanes];
      std::fill(same, same + kLanes, dF);
      const Point<Pack<float>> p = point(low, test::packed(F));
      const Mat3<Pack<float>> dP = apply(p.hessian, p.svd, test::packed(same));
      // each lane against the law in double
      for (int lane = 0; lane < kLanes; ++lane) {
        const Point<double> exact = point(high, test::cast<double>(F[lane]));
        ASSERT_NEAR(p.r.psi[lane], exact.r.psi, 1e-5);
        ASSERT_LT(test::distance(test::cast<double>(test::lane_of<float>(p.P, lane)), exact.P),
                  2e-5);
        const Mat3<double> reference = apply(exact.hessian, exact.svd, test::cast<double>(dF));
        ASSERT_LT(test::distance(test::cast<double>(test::lane_of<float>(dP, lane)), reference),
                  1e-2 * test::norm(reference));
      }
    }
  }
}

}  // namespace
}  // namespace elastogen
