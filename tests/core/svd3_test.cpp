// SPDX-License-Identifier: Apache-2.0
#include "core/svd3.hpp"

#include "core/polar.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

using test::Random;

constexpr int kPacks = 25000;

/// Worst errors over a family, in units of eps; measured with a wider type than the one tested.
struct Worst {
  double reconstruction = 0, U = 0, V = 0, determinant = 0, order = 0, product = 0;
  bool finite = true;
};

template <class Wide>
Wide orthogonality(const Mat3<Wide>& Q) {
  return test::distance(transposed_times(Q, Q), identity<Wide>());
}

template <class S, class Wide>
void measure(const Mat3<S>& F, const Svd3<S>& s, Worst& worst) {
  const Wide eps = std::numeric_limits<S>::epsilon();
  const Mat3<Wide> A = test::cast<Wide>(F), U = test::cast<Wide>(s.U), V = test::cast<Wide>(s.V);
  const Wide sigma[3] = {s.sigma[0], s.sigma[1], s.sigma[2]};
  Mat3<Wide> US;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) US(i, j) = U(i, j) * sigma[j];
  const Wide size = test::norm(A), unit = size > 0 ? eps * size : eps;
  const auto raise = [&](double& to, Wide value) {
    worst.finite = worst.finite && std::isfinite(double(value));
    to = std::max(to, double(value));
  };
  raise(worst.reconstruction, test::distance(A, times_transposed(US, V)) / unit);
  raise(worst.U, orthogonality(U) / eps);
  raise(worst.V, orthogonality(V) / eps);
  raise(worst.determinant,
        std::max(std::abs(determinant(U) - 1), std::abs(determinant(V) - 1)) / eps);
  raise(worst.order, std::max(sigma[1] - sigma[0], std::abs(sigma[2]) - sigma[1]) / unit);
  const Wide cube = size > 0 ? unit * size * size : eps;
  raise(worst.product, std::abs(sigma[0] * sigma[1] * sigma[2] - determinant(A)) / cube);
}

template <class S, class Wide>
void expect_decomposes(const test::Family& family) {
  SCOPED_TRACE(family.name);
  Random random(1);
  Worst worst;
  int unequal = 0;
  for (int k = 0; k < kPacks; ++k) {
    Mat3<S> F[kLanes];
    for (Mat3<S>& f : F) f = test::cast<S>(family.draw(random));
    const Svd3<Pack<S>> all = svd3(test::packed(F));
    for (int lane = 0; lane < kLanes; ++lane) {
      Svd3<S> one{test::lane_of<S>(all.U, lane), {}, test::lane_of<S>(all.V, lane)};
      for (int j = 0; j < 3; ++j) one.sigma[j] = all.sigma[j][lane];
      measure<S, Wide>(F[lane], one, worst);
    }
    // one lane of each pack again as a scalar
    const int lane = k % kLanes;
    const Svd3<S> scalar = svd3(F[lane]);
    for (int j = 0; j < 3; ++j) unequal += scalar.sigma[j] != all.sigma[j][lane];
    for (int j = 0; j < 9; ++j)
      unequal += scalar.U.m[j] != all.U.m[j][lane] || scalar.V.m[j] != all.V.m[j][lane];
  }
  EXPECT_TRUE(worst.finite);
  EXPECT_LE(worst.reconstruction, 35);
  EXPECT_LE(worst.U, 35);
  EXPECT_LE(worst.V, 35);
  EXPECT_LE(worst.determinant, 35);
  EXPECT_LE(worst.order, 8);
  EXPECT_LE(worst.product, 35);
  EXPECT_EQ(unequal, 0) << "numbers that differ between pack and scalar";
}

TEST(Svd3, DecomposesEveryFamilyInDoubleToAFewEps) {
  for (const test::Family& family : test::kFamilies) expect_decomposes<double, long double>(family);
}

TEST(Svd3, DecomposesEveryFamilyInFloatToAFewEps) {
  for (const test::Family& family : test::kFamilies) expect_decomposes<float, double>(family);
}

TEST(Svd3, RecoversTheStretchesThatAMatrixWasMadeOf) {
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const double s[3] = {2.5, 1.25, k % 2 ? 0.5 : -0.5};
    const Svd3<double> svd = svd3(test::stretched(s[0], s[1], s[2], random));
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(svd.sigma[j], s[j], 1e-14);
  }
}

TEST(Svd3, SmallestStretchAndRotationAreContinuousThroughZero) {
  Random random(3);
  const Mat3<double> R = test::rotation(random), Q = test::rotation(random);
  for (const double t : {-1e-2, -1e-6, -1e-14, -1e-18, 0.0, 1e-300, 1e-14, 1e-6, 1e-2}) {
    SCOPED_TRACE(t);
    Mat3<double> Rt = R;
    const double s[3] = {1.3, 0.8, t};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) Rt(i, j) *= s[j];
    const Mat3<double> F = Rt * Q;
    EXPECT_NEAR(svd3(F).sigma[2], t, 1e-15);
    EXPECT_LT(test::distance(polar_rotation(F), R * Q), 1e-14);
  }
}

TEST(Svd3, PolarRotationOfARotatedPositiveMatrixIsTheRotation) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const Mat3<double> R = test::rotation(random), Q = test::rotation(random);
    Mat3<double> QS = Q;
    const double s[3] = {2, 0.7, 1e-3};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) QS(i, j) *= s[j];
    EXPECT_LT(test::distance(polar_rotation(R * times_transposed(QS, Q)), R), 1e-11);
  }
}

/// dR = U W V^T with W_ij = (G_ij - G_ji) / (s_i + s_j), G = U^T dF V.
TEST(Svd3, PolarRotationHasTheDerivativeOfItsClosedForm) {
  for (int k = 0; k < 300; ++k) {
    Mat3<double> F, dF, plus, minus, W{};
    for (int e = 0; e < 9; ++e) {
      F.m[e] = (e % 4 == 0) + 0.5 * std::sin(1.7 * k + 2.3 * e + 0.1 * k * e);
      dF.m[e] = std::cos(0.9 * k + 1.3 * e * e);
    }
    const Svd3<double> svd = svd3(F);
    if (svd.sigma[1] + svd.sigma[2] < 0.05) continue;
    const double step = 1e-5;
    for (int e = 0; e < 9; ++e) {
      plus.m[e] = F.m[e] + step * dF.m[e];
      minus.m[e] = F.m[e] - step * dF.m[e];
    }
    const Mat3<double> G = transposed_times(svd.U, dF) * svd.V;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (i != j) W(i, j) = (G(i, j) - G(j, i)) / (svd.sigma[i] + svd.sigma[j]);
    const Mat3<double> exact = times_transposed(svd.U * W, svd.V);
    const Mat3<double> above = polar_rotation(plus), below = polar_rotation(minus);
    for (int e = 0; e < 9; ++e)
      ASSERT_NEAR((above.m[e] - below.m[e]) / (2 * step), exact.m[e], 1e-4) << k;
  }
}

TEST(Svd3, PolarRotationIsCloserThanItsNeighboursAlsoForMirroredMatrices) {
  Random random(5);
  for (int k = 0; k < 200; ++k) {
    const Mat3<double> F = test::stretched(1.4, 0.9, -0.3, random), R = polar_rotation(F);
    for (int n = 0; n < 20; ++n)
      EXPECT_LT(test::distance(F, R), test::distance(F, R * test::rotation_by(0.1, random)));
  }
}

TEST(Svd3, UniqueRotationIsThePolarFactorOrNothing) {
  test::Random random(11);
  for (const double third : {0.9, 0.2, 0.0, -0.3}) {
    const Mat3<double> F = test::stretched(1.4, 0.9, third, random);
    EXPECT_EQ(test::distance(unique_rotation(F), polar_rotation(F)), 0) << third;
  }
  // mirrored, on a line, a point: every rotation about an axis, or every one, would do
  for (const Mat3<double>& F :
       {test::stretched(1.4, 0.9, -0.9, random), test::stretched(1, 0, 0, random),
        test::stretched(1e-9, 1e-9, 1e-9, random), Mat3<double>{}})
    EXPECT_EQ(test::norm(unique_rotation(F)), 0);
}

}  // namespace
}  // namespace elastogen
