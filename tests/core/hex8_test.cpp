// SPDX-License-Identifier: Apache-2.0
#include "core/hex8.hpp"

#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace elastogen {
namespace {

using test::Random;

constexpr double kEdge = 0.5;  // h

double sign(int corner, int axis) {
  return corner >> axis & 1 ? 1 : -1;
}

void draw(double* values, int count, Random& random) {
  std::normal_distribution<double> normal;
  for (int k = 0; k < count; ++k) values[k] = normal(random);
}

/// Gradient of the trilinear interpolation of corner values u at place X from the centre.
void trilinear_gradient(const double u[8], const double X[3], double result[3]) {
  for (int d = 0; d < 3; ++d) {
    result[d] = 0;
    for (int c = 0; c < 8; ++c) {
      double slope = u[c] * sign(c, d) / kEdge;
      for (int e = 0; e < 3; ++e)
        if (e != d) slope *= 0.5 + sign(c, e) * X[e] / kEdge;
      result[d] += slope;
    }
  }
}

/// Integral over the box [lower, upper] of f(X), by three Gauss points an axis.
double integral(const double lower[3], const double upper[3],
                const std::function<double(const double X[3])>& f) {
  const double point[3] = {-std::sqrt(0.6), 0, std::sqrt(0.6)};
  const double weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  double sum = 0, volume = 1;
  for (int d = 0; d < 3; ++d) volume *= upper[d] - lower[d];
  for (int k = 0; k < 27; ++k) {
    const int index[3] = {k % 3, k / 3 % 3, k / 9};
    double X[3], w = volume;
    for (int d = 0; d < 3; ++d) {
      X[d] = (lower[d] + upper[d] + point[index[d]] * (upper[d] - lower[d])) / 2;
      w *= weight[index[d]];
    }
    sum += w * f(X);
  }
  return sum;
}

constexpr double kLower[3] = {-kEdge / 2, -kEdge / 2, -kEdge / 2};
constexpr double kUpper[3] = {kEdge / 2, kEdge / 2, kEdge / 2};

/// A voxel of which a box is filled: means of the shape functions, moments, centroid.
struct CutVoxel {
  double lower[3], upper[3], centroid[3], volume = 1, shape_mean[8], M[7];

  explicit CutVoxel(Random& random) {
    std::uniform_real_distribution<double> cut(-kEdge / 2, kEdge / 2);
    for (int d = 0; d < 3; ++d) {
      const double a = cut(random), b = cut(random);
      lower[d] = std::min(a, b), upper[d] = std::max(a, b);
      centroid[d] = (a + b) / 2;
      volume *= upper[d] - lower[d];
    }
    for (int c = 0; c < 8; ++c)
      shape_mean[c] = integral(lower, upper,
                               [&](const double X[3]) {
                                 double N = 1;
                                 for (int d = 0; d < 3; ++d) N *= 0.5 + sign(c, d) * X[d] / kEdge;
                                 return N;
                               }) /
                      volume;
    hex8::fill_moments(shape_mean, M);
  }
};

TEST(Hex8, PatternSumsAreThoseOfTheDefinition) {
  Random random(1);
  double u[8], g[8];
  draw(u, 8, random);
  std::copy(u, u + 8, g);
  hex8::to_patterns(g);
  for (int p = 0; p < 8; ++p) {
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      double factor = 1;
      for (int d = 0; d < 3; ++d)
        if (p >> d & 1) factor *= sign(c, d);
      sum += factor * u[c];
    }
    EXPECT_NEAR(g[p], sum, 1e-14);
  }
}

TEST(Hex8, CornersAreTheTransposeOfPatternsAndEightTimesTheirInverse) {
  Random random(2);
  double u[8], w[8], g[8], f[8], back[8];
  draw(u, 8, random), draw(w, 8, random);
  std::copy(u, u + 8, g), std::copy(w, w + 8, f);
  hex8::to_patterns(g), hex8::to_corners(f);
  double patterns = 0, corners = 0;
  for (int k = 0; k < 8; ++k) patterns += g[k] * w[k], corners += u[k] * f[k];
  EXPECT_NEAR(patterns, corners, 1e-13);
  std::copy(g, g + 8, back);
  hex8::to_corners(back);
  for (int k = 0; k < 8; ++k) EXPECT_NEAR(back[k], 8 * u[k], 1e-13);
}

TEST(Hex8, MomentsOfAFullVoxelVanish) {
  double mean[8], M[7];
  std::fill(mean, mean + 8, 0.125);
  hex8::fill_moments(mean, M);
  for (int p = 1; p < 7; ++p) EXPECT_EQ(M[p], 0);
}

TEST(Hex8, GradientIsTheMeanOfTheTrilinearGradientOverTheFill) {
  Random random(3);
  for (int k = 0; k < 20; ++k) {
    const CutVoxel voxel(random);
    double u[8], g[8], result[3];
    draw(u, 8, random);
    std::copy(u, u + 8, g);
    hex8::to_patterns(g);
    hex8::gradient<true>(g, voxel.M, result);
    for (int d = 0; d < 3; ++d) {
      const double mean = integral(voxel.lower, voxel.upper,
                                   [&](const double X[3]) {
                                     double slope[3];
                                     trilinear_gradient(u, X, slope);
                                     return slope[d];
                                   }) /
                          voxel.volume;
      EXPECT_NEAR(result[d] / (4 * kEdge), mean, 1e-12);
    }
  }
}

TEST(Hex8, GradientOfAFullVoxelIsTheOneAtItsCentre) {
  Random random(4);
  double u[8], g[8], result[3], centre[3];
  const double origin[3] = {};
  draw(u, 8, random);
  std::copy(u, u + 8, g);
  hex8::to_patterns(g);
  hex8::gradient<false>(g, static_cast<const double*>(nullptr), result);
  trilinear_gradient(u, origin, centre);
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(result[d] / (4 * kEdge), centre[d], 1e-14);
}

TEST(Hex8, CentredPatternsAreTheMixedDerivativesAtTheCentroidOfTheFill) {
  Random random(5);
  for (int k = 0; k < 20; ++k) {
    const CutVoxel voxel(random);
    double u[8], g[8], q[4];
    draw(u, 8, random);
    std::copy(u, u + 8, g);
    hex8::to_patterns(g);
    hex8::centred_patterns<true>(g, voxel.M, q);
    const int axes[3][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}};  // pair and the third axis
    for (int p = 0; p < 3; ++p) {
      const auto [a, b, other] = axes[p];
      double mixed = 0, triple = 0;
      for (int c = 0; c < 8; ++c) {
        mixed += u[c] * sign(c, a) * sign(c, b) *
                 (0.5 + sign(c, other) * voxel.centroid[other] / kEdge) / (kEdge * kEdge);
        triple += u[c] * sign(c, 0) * sign(c, 1) * sign(c, 2);
      }
      EXPECT_NEAR(q[p] / (2 * kEdge * kEdge), mixed, 1e-12);
      EXPECT_NEAR(q[3], triple, 1e-13);
    }
  }
}

TEST(Hex8, TransposesAreAdjoint) {
  Random random(6);
  const CutVoxel voxel(random);
  double g[8], d[3], q[4], slope[3], centred[4], back[8] = {}, back_q[8] = {};
  draw(g, 8, random), draw(d, 3, random), draw(q, 4, random);
  hex8::gradient<true>(g, voxel.M, slope);
  hex8::add_gradient_transposed<true>(d, voxel.M, back);
  hex8::centred_patterns<true>(g, voxel.M, centred);
  hex8::add_centred_transposed<true>(q, voxel.M, back_q);
  double left = 0, right = 0, left_q = 0, right_q = 0;
  for (int k = 0; k < 3; ++k) left += slope[k] * d[k];
  for (int k = 0; k < 4; ++k) left_q += centred[k] * q[k];
  for (int k = 0; k < 8; ++k) right += g[k] * back[k], right_q += g[k] * back_q[k];
  EXPECT_NEAR(left, right, 1e-13);
  EXPECT_NEAR(left_q, right_q, 1e-13);

  hex8::gradient<false>(g, voxel.M, slope);
  std::fill(back, back + 8, 0);
  hex8::add_gradient_transposed<false>(d, voxel.M, back);
  left = right = 0;
  for (int k = 0; k < 3; ++k) left += slope[k] * d[k];
  for (int k = 0; k < 8; ++k) right += g[k] * back[k];
  EXPECT_NEAR(left, right, 1e-13);
}

TEST(Hex8, AffineFieldsHaveTheirGradientAndNoPatterns) {
  Random random(7);
  const CutVoxel voxel(random);
  double slope[4], g[8], result[3], q[4];
  draw(slope, 4, random);
  for (int c = 0; c < 8; ++c)
    g[c] = slope[3] +
           kEdge / 2 * (slope[0] * sign(c, 0) + slope[1] * sign(c, 1) + slope[2] * sign(c, 2));
  hex8::to_patterns(g);
  hex8::gradient<true>(g, voxel.M, result);
  hex8::centred_patterns<true>(g, voxel.M, q);
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(result[d] / (4 * kEdge), slope[d], 1e-14);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(q[k], 0, 1e-14);
}

TEST(Hex8, VarianceIsTheIntegralOfTheSquaredDeviationOfTheGradient) {
  Random random(8);
  for (int k = 0; k < 20; ++k) {
    double u[8], g[8], q[4], slope[4], centre[3];
    draw(u, 8, random);
    std::copy(u, u + 8, g);
    hex8::to_patterns(g);
    hex8::centred_patterns<false>(g, static_cast<const double*>(nullptr), q);
    const double c[4] = {3, 3, 3, 3}, origin[3] = {};
    trilinear_gradient(u, origin, centre);
    const double exact = integral(kLower, kUpper, [&](const double X[3]) {
      double here[3], sum = 0;
      trilinear_gradient(u, X, here);
      for (int d = 0; d < 3; ++d) sum += (here[d] - centre[d]) * (here[d] - centre[d]);
      return 1.5 * sum;
    });
    const double energy = hex8::variance(q, c, slope);
    EXPECT_NEAR(kEdge * energy, exact, 1e-13);
    double twice = 0;
    for (int p = 0; p < 4; ++p) twice += slope[p] * q[p];
    EXPECT_NEAR(twice, 2 * energy, 1e-13);
  }
}

TEST(Hex8, VarianceWeighsEachPatternByItsOwnWeight) {
  for (int p = 0; p < 4; ++p) {
    double q[4] = {}, slope[4];
    const double c[4] = {2, 3, 5, 7};
    q[p] = 4;
    EXPECT_NEAR(hex8::variance(q, c, slope), c[p] * 16 / (p < 3 ? 48 : 96), 1e-14);
  }
}

/// Corner values of a displacement field, in pattern sums, and from there the centred patterns.
void patterns_of(const std::function<void(const double X[3], double u[3])>& field, double q[3][4]) {
  double g[3][8];
  for (int c = 0; c < 8; ++c) {
    const double X[3] = {sign(c, 0) * kEdge / 2, sign(c, 1) * kEdge / 2, sign(c, 2) * kEdge / 2};
    double u[3];
    field(X, u);
    for (int i = 0; i < 3; ++i) g[i][c] = u[i];
  }
  for (int i = 0; i < 3; ++i) {
    hex8::to_patterns(g[i]);
    hex8::centred_patterns<false>(g[i], static_cast<const double*>(nullptr), q[i]);
  }
}

/// Variance and torsion energy [J] of a full voxel.
double stabilisation(const double q[3][4], const double c[4], double mu, const double R[9]) {
  double slope[3][4], energy = 0;
  for (int i = 0; i < 3; ++i) energy += hex8::variance(q[i], c, slope[i]);
  return kEdge * (energy + hex8::torsion(q, c, mu, R, slope));
}

TEST(Hex8, TorsionGivesTwistItsExactIsotropicEnergyInAnyOrientation) {
  Random random(9);
  for (int k = 0; k < 10; ++k) {
    double a[3];
    draw(a, 3, random);
    const Mat3<double> R = test::rotation(random);
    const double c[4] = {1.3, 0.7, 2.1, 1}, mu = 1.7;
    double q[3][4];
    patterns_of(
        [&](const double X[3], double u[3]) {
          const double local[3] = {a[0] * X[1] * X[2], a[1] * X[2] * X[0], a[2] * X[0] * X[1]};
          for (int i = 0; i < 3; ++i)
            u[i] = R(i, 0) * local[0] + R(i, 1) * local[1] + R(i, 2) * local[2];
        },
        q);
    // engineering shear strains of the field in its own frame; it changes no volume
    const double exact = integral(kLower, kUpper, [&](const double X[3]) {
      const double xy = (a[0] + a[1]) * X[2], yz = (a[1] + a[2]) * X[0], zx = (a[2] + a[0]) * X[1];
      return mu / 2 * (xy * xy + yz * yz + zx * zx);
    });
    // the turned field has other components too, which the weights charge; equal ones cancel
    const double same[4] = {1.3, 1.3, 1.3, 1};
    EXPECT_NEAR(stabilisation(q, same, mu, R.m), exact, 1e-13 * (1 + exact));
    if (k > 0) continue;
    const Mat3<double> I = identity<double>();
    patterns_of(
        [&](const double X[3], double u[3]) {
          u[0] = a[0] * X[1] * X[2], u[1] = a[1] * X[2] * X[0], u[2] = a[2] * X[0] * X[1];
        },
        q);
    EXPECT_NEAR(stabilisation(q, c, mu, I.m), exact, 1e-13 * (1 + exact));
  }
}

TEST(Hex8, TorsionTouchesNothingButTwist) {
  const double c[4] = {2, 3, 5, 7};
  const Mat3<double> I = identity<double>();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k) {
      const bool twist = (i == 0 && k == 1) || (i == 1 && k == 2) || (i == 2 && k == 0);
      double q[3][4] = {}, slope[3][4] = {};
      q[i][k] = 1;
      const double energy = hex8::torsion(q, c, 4.0, I.m, slope);
      // mu (a+b)^2 + mu (c+a)^2 - 2 c_k over 96
      EXPECT_NEAR(energy, twist ? (2 * 4.0 - 2 * c[k]) / 96 : 0, 1e-15);
    }
}

TEST(Hex8, TorsionSlopeIsTheDerivativeOfItsEnergy) {
  Random random(10);
  const Mat3<double> R = test::rotation(random);
  const double c[4] = {2, 3, 5, 7};
  double q[3][4], slope[3][4] = {}, ignored[3][4] = {};
  draw(&q[0][0], 12, random);
  hex8::torsion(q, c, 1.5, R.m, slope);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k) {
      const double middle = q[i][k];
      q[i][k] = middle + 0.5;
      const double up = hex8::torsion(q, c, 1.5, R.m, ignored);
      q[i][k] = middle - 0.5;
      const double down = hex8::torsion(q, c, 1.5, R.m, ignored);
      q[i][k] = middle;
      EXPECT_NEAR(slope[i][k], up - down, 1e-13);  // exact for a quadratic
    }
}

}  // namespace
}  // namespace elastogen
