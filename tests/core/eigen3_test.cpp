// SPDX-License-Identifier: Apache-2.0
#include "core/eigen3.hpp"

#include "core/spectrum3.hpp"
#include "tests/support/eigenvalues.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace elastogen {
namespace {

using test::Random;

Mat3<double> full(const Symmetric3<double>& A) {
  return {{A.m[0], A.m[3], A.m[5], A.m[3], A.m[1], A.m[4], A.m[5], A.m[4], A.m[2]}};
}

Eigen::MatrixXd dense(const Symmetric3<double>& A) {
  Eigen::MatrixXd result(3, 3);
  const Mat3<double> M = full(A);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result(i, j) = M(i, j);
  return result;
}

/// Q diag(a, b, c) Q^T.
Symmetric3<double> with_eigenvalues(double a, double b, double c, Random& random) {
  const double value[3] = {a, b, c};
  const Mat3<double> Q = test::rotation(random);
  Symmetric3<double> A{};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      A.m[i] += value[k] * Q(i, k) * Q(i, k);
      A.m[3 + i] += value[k] * Q(i, k) * Q((i + 1) % 3, k);
    }
  return A;
}

/// Random, repeated, nearly repeated, singular, diagonal and widely scaled matrices.
std::vector<Symmetric3<double>> samples() {
  Random random(1);
  std::normal_distribution<double> normal;
  std::vector<Symmetric3<double>> result = {{{0, 0, 0, 0, 0, 0}}, {{1, -2, 3, 0, 0, 0}}};
  for (int k = 0; k < 300; ++k) {
    Symmetric3<double> A;
    for (double& a : A.m) a = normal(random);
    result.push_back(A);
    for (double& a : A.m) a *= 1e100;
    result.push_back(A);
    result.push_back(with_eigenvalues(2, 2, -1, random));
    result.push_back(with_eigenvalues(1, 1 + 1e-9, 1 - 1e-9, random));
    result.push_back(with_eigenvalues(5, 0, -1e-12, random));
    result.push_back(with_eigenvalues(1e8, 1, -1e-8, random));
  }
  return result;
}

TEST(Eigen3, ValuesAgreeWithEigenAndVectorsRebuildTheMatrix) {
  for (const Symmetric3<double>& A : samples()) {
    const double unit = 1e-15 * std::max(1e-300, dense(A).norm());
    Eigen3<double> e = eigen3(A);
    Mat3<double> QD = e.Q;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) QD(i, j) *= e.value[j];
    const Mat3<double> rebuilt = times_transposed(QD, e.Q), M = full(A);
    for (int k = 0; k < 9; ++k) ASSERT_NEAR(rebuilt.m[k], M.m[k], 10 * unit);
    ASSERT_LT(test::distance(transposed_times(e.Q, e.Q), identity<double>()), 1e-14);
    std::sort(e.value, e.value + 3);
    const Eigen::VectorXd reference = test::eigenvalues(dense(A));
    for (int k = 0; k < 3; ++k) ASSERT_NEAR(e.value[k], reference(k), 10 * unit);
  }
}

TEST(Eigen3, PositivePartIsTheClampedMatrixOfEigen) {
  for (const Symmetric3<double>& A : samples()) {
    const Eigen::MatrixXd difference = dense(positive_part(A)) - test::clamped(dense(A));
    ASSERT_LE(difference.norm(), 2e-14 * dense(A).norm());
  }
}

TEST(Eigen3, PositivePartLeavesPositiveMatricesUntouchedToTheBit) {
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const Symmetric3<double> A = with_eigenvalues(3, 1, 1e-3, random), B = positive_part(A);
    for (int i = 0; i < 6; ++i) ASSERT_EQ(A.m[i], B.m[i]);
  }
}

/// Angles as small as Green's strains have them: off-diagonal numbers far below the diagonal's
/// still turn the axes, and a diagonal matrix needs no turn at all.
TEST(Eigen3, TurnsBySmallAnglesToo) {
  for (const double angle : {0.0, 1e-15, 1e-12, 1e-8, 1e-4}) {
    // diag(2, 1, 0) turned about the third axis: the coupling of 0 and 1 is sin 2x/2
    const double s = std::sin(angle), c = std::cos(angle);
    const Eigen3<double> e = eigen3(Symmetric3<double>{{1 + c * c, 1 + s * s, 0, s * c, 0, 0}});
    EXPECT_NEAR(e.value[0], 2, 1e-15);
    EXPECT_NEAR(e.value[1], 1, 1e-15);
    EXPECT_EQ(e.value[2], 0);
    EXPECT_NEAR(e.Q(1, 0), s, 1e-15);
    EXPECT_NEAR(e.Q(0, 1), -s, 1e-15);
  }
}

TEST(Eigen3, PacksDoWhatScalarsDo) {
  const std::vector<Symmetric3<double>> all = samples();
  for (size_t k = 0; k + kLanes <= all.size(); k += kLanes) {
    Symmetric3<Pack<double>> A;
    for (int lane = 0; lane < kLanes; ++lane)
      for (int i = 0; i < 6; ++i) A.m[i][lane] = all[k + lane].m[i];
    const Symmetric3<Pack<double>> B = positive_part(A);
    for (int lane = 0; lane < kLanes; ++lane)
      for (int i = 0; i < 6; ++i) ASSERT_EQ(B.m[i][lane], positive_part(all[k + lane]).m[i]);
  }
}

/// The value apart and mean and product of the pair to some eps of the matrix.
TEST(Spectrum3, ValuesAreThoseOfEigen) {
  for (const Symmetric3<double>& A : samples()) {
    const double unit = std::max(1e-300, dense(A).norm());
    const Spectrum3<double> s = spectrum3(A);
    const Eigen::VectorXd sorted = test::eigenvalues(dense(A)) / unit;
    const int apart = s.t[0] < 0 ? 0 : 2, low = apart == 0 ? 1 : 0;
    ASSERT_NEAR(s.value(0) / unit, sorted(apart), 2e-15);
    const double a = s.value(1) / unit, b = s.value(2) / unit;
    ASSERT_NEAR(a + b, sorted(low) + sorted(low + 1), 4e-15);
    ASSERT_NEAR(a * b, sorted(low) * sorted(low + 1), 4e-15);
    ASSERT_GT(s.t[1], s.t[2]);
  }
}

/// Error of sum_i exp(a_i) v_i v_i^T against the sum over eigenvectors.
template <class T>
double isotropic_error(const Symmetric3<double>& A) {
  Symmetric3<T> B;
  for (int k = 0; k < 6; ++k) B.m[k] = T(A.m[k]);
  const Spectrum3<T> s = spectrum3(B);
  const T f[3] = {std::exp(s.value(0)), std::exp(s.value(1)), std::exp(s.value(2))};
  const Symmetric3<T> found = s.isotropic(f);
  Symmetric3<double> in_double;
  for (int k = 0; k < 6; ++k) in_double.m[k] = double(found.m[k]);
  const Eigen3<double> axes = eigen3(A);
  Symmetric3<double> exact{};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      exact.m[i] += std::exp(axes.value[k]) * axes.Q(i, k) * axes.Q(i, k);
      exact.m[3 + i] += std::exp(axes.value[k]) * axes.Q(i, k) * axes.Q((i + 1) % 3, k);
    }
  return (dense(in_double) - dense(exact)).norm() / dense(exact).norm();
}

TEST(Spectrum3, IsotropicFunctionsAreThoseByEigenvectors) {
  Random random(4);
  for (int k = 0; k < 200; ++k)
    for (const double apart : {0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 0.1, 0.5})
      for (const double third : {0.0, 1e-14, 1e-8, -1e-4, 0.3, -0.7}) {
        const Symmetric3<double> A =
            with_eigenvalues(0.2, 0.2 + apart, 0.2 + apart / 3 + third, random);
        ASSERT_LT(isotropic_error<double>(A), 3e-15) << apart << ' ' << third;
        ASSERT_LT(isotropic_error<float>(A), 2e-6) << apart << ' ' << third;
      }
}

TEST(Spectrum3, DiagonalMatricesKeepTheirDiagonal) {
  const Spectrum3<double> zero = spectrum3(Symmetric3<double>{});
  const double f[3] = {2, 2, 2};
  const Symmetric3<double> same = zero.isotropic(f);
  for (int k = 0; k < 6; ++k) {
    EXPECT_EQ(same.m[k], k < 3 ? 2 : 0);
    EXPECT_EQ(zero.value(k % 3), 0);
  }
}

}  // namespace
}  // namespace elastogen
