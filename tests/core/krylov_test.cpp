// SPDX-License-Identifier: Apache-2.0
#include "core/krylov.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>

namespace elastogen {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// A random matrix, not symmetric, with eigenvalues about `shift`.
Matrix random_matrix(int size, double shift, int seed) {
  std::mt19937 random{uint32_t(seed)};
  std::normal_distribution<double> normal(0, 1 / std::sqrt(double(size)));
  Matrix A(size, size);
  for (double& a : A.reshaped()) a = normal(random);
  return A + shift * Matrix::Identity(size, size);
}

Vector some_vector(int size) {
  return Vector::LinSpaced(size, -1, 2).array().cos();
}

/// With `inverse` as preconditioner.
KrylovResult solve(const Matrix& A, const Matrix& inverse, const Vector& b, Vector& x,
                   double tolerance, int restart = 30, int most = 1000) {
  const Eigen::Index size = b.size();
  x = Vector::Constant(size, 7);  // must not matter
  GmresWork<double> work(size, restart);
  const auto times = [&](const Matrix& M) {
    return [&M, size](const double* p, double* Mp) {
      Eigen::Map<Vector>(Mp, size) = M * Eigen::Map<const Vector>(p, size);
    };
  };
  return gmres(b.data(), x.data(), size, tolerance, most, work, times(A), times(inverse));
}

KrylovResult solve(const Matrix& A, const Vector& b, Vector& x, double tolerance, int restart = 30,
                   int most = 1000) {
  return solve(A, Matrix::Identity(A.rows(), A.rows()), b, x, tolerance, restart, most);
}

TEST(Gmres, AgreesWithADirectSolverAndReportsItsTrueResidual) {
  for (const int restart : {5, 30, 200}) {
    const Matrix A = random_matrix(120, 2, 1);
    const Vector b = some_vector(120), exact = A.partialPivLu().solve(b);
    Vector x;
    const KrylovResult result = solve(A, b, x, 1e-12, restart);
    EXPECT_EQ(result.stop, KrylovStop::kConverged);
    EXPECT_LT((x - exact).norm(), 1e-10 * exact.norm()) << restart;
    EXPECT_NEAR(result.residual, (b - A * x).norm() / b.norm(), 1e-15);
    EXPECT_LE(result.residual, 1e-12);
  }
}

TEST(Gmres, EndsAfterAsManyIterationsAsThereAreEigenvalues) {
  // a triangular matrix with two different ones, each with all its eigenvectors
  Matrix A = Matrix::Identity(6, 6);
  A.bottomRightCorner(3, 3) *= 4;
  A.topRightCorner(3, 3).setConstant(0.5);
  Vector x;
  const Vector b = some_vector(6);
  const KrylovResult result = solve(A, b, x, 1e-14);
  EXPECT_EQ(result.stop, KrylovStop::kConverged);
  EXPECT_EQ(result.iterations, 2);
  EXPECT_LT((A * x - b).norm(), 1e-14 * b.norm());
}

TEST(Gmres, TakesOneIterationWithTheInverseAsPreconditioner) {
  const Matrix A = random_matrix(40, 1.5, 2);
  Vector x;
  const KrylovResult result = solve(A, A.inverse(), some_vector(40), x, 1e-10);
  EXPECT_EQ(result.stop, KrylovStop::kConverged);
  EXPECT_EQ(result.iterations, 1);
}

TEST(Gmres, SaysWhereItBreaksDown) {
  // a cyclic shift: nothing is gained before the last of n iterations, so a shorter cycle is stuck
  Matrix shift = Matrix::Zero(8, 8);
  for (int k = 0; k < 8; ++k) shift((k + 1) % 8, k) = 1;
  Vector x, b = Vector::Unit(8, 0);
  EXPECT_EQ(solve(shift, b, x, 1e-10, 4).stop, KrylovStop::kBreakdown);
  EXPECT_EQ(solve(shift, b, x, 1e-10, 8).stop, KrylovStop::kConverged);
  EXPECT_LT((shift * x - b).norm(), 1e-14);

  // singular matrices with a right-hand side out of their range; x stays finite
  Matrix singular = Matrix::Identity(4, 4);
  singular(3, 3) = 0;
  b = Vector::Ones(4);
  EXPECT_EQ(solve(singular, b, x, 1e-10).stop, KrylovStop::kBreakdown);
  EXPECT_TRUE(x.allFinite());
  EXPECT_EQ(solve(Matrix::Zero(4, 4), b, x, 1e-10).stop, KrylovStop::kBreakdown);
  EXPECT_EQ(x, Vector::Zero(4));

  singular(0, 0) = NAN;
  EXPECT_EQ(solve(singular, b, x, 1e-10).stop, KrylovStop::kBreakdown);
  b(0) = NAN;
  EXPECT_EQ(solve(Matrix::Identity(4, 4), b, x, 1e-10).stop, KrylovStop::kBreakdown);
}

TEST(Gmres, SolvesASingularSystemWithinItsRange) {
  Matrix A = random_matrix(20, 3, 3);
  A.row(7).setZero();
  Vector b = some_vector(20), x;
  b(7) = 0;
  EXPECT_EQ(solve(A, b, x, 1e-10).stop, KrylovStop::kConverged);
  EXPECT_LT((A * x - b).norm(), 1e-10 * b.norm());
}

TEST(Gmres, StopsAtTheLimitOfIterations) {
  Vector x;
  const KrylovResult result = solve(random_matrix(120, 2, 1), some_vector(120), x, 1e-12, 10, 13);
  EXPECT_EQ(result.stop, KrylovStop::kIterations);
  EXPECT_EQ(result.iterations, 13);
  EXPECT_LT(result.residual, 1);
}

TEST(Gmres, TakesZeroAndNothing) {
  Vector x;
  const KrylovResult zero = solve(random_matrix(5, 2, 1), Vector::Zero(5), x, 0);
  EXPECT_EQ(zero.stop, KrylovStop::kConverged);
  EXPECT_EQ(zero.iterations, 0);
  EXPECT_EQ(x, Vector::Zero(5));
  EXPECT_EQ(solve(Matrix(0, 0), Vector(0), x, 0).stop, KrylovStop::kConverged);
}

TEST(Gmres, HasFloatsPrecisionInFloat) {
  const Eigen::MatrixXf A = random_matrix(60, 2, 4).cast<float>();
  const Eigen::VectorXf b = some_vector(60).cast<float>();
  Eigen::VectorXf x(60);
  GmresWork<float> work(60);
  const KrylovResult result = gmres(
      b.data(), x.data(), 60, 1e-6, 200, work,
      [&](const float* p, float* Ap) {
        Eigen::Map<Eigen::VectorXf>(Ap, 60) = A * Eigen::Map<const Eigen::VectorXf>(p, 60);
      },
      [](const float* r, float* z) { std::copy(r, r + 60, z); });
  EXPECT_EQ(result.stop, KrylovStop::kConverged);
  EXPECT_LT((A * x - b).norm(), 2e-6f * b.norm());
}

}  // namespace
}  // namespace elastogen
