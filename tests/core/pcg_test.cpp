// SPDX-License-Identifier: Apache-2.0
#include "core/pcg.hpp"

#include "tests/support/element_assembly.hpp"

#include <gtest/gtest.h>

#include <random>
#include <utility>

namespace elastogen {
namespace {

/// M/dt^2 + K of a box with dt = 1/60 s; E from 1e3 to 1e7 Pa.
Eigen::SparseMatrix<double> system_matrix(int k) {
  const double poisson[4] = {0, 0.3, 0.45, 0.49};
  const Material material{"m", Law::kNeoHookean, 1e3 * std::pow(10, k % 5), poisson[k % 4], 1000};
  const Scene scene = test::box_scene(2 + k % 3, 3, 2 + k % 2, 0.05, material);
  Eigen::SparseMatrix<double> A = test::rest_stiffness(scene);
  for (int64_t n = 0; n < scene.mass.rows(); ++n)
    for (int i = 0; i < 3; ++i)
      A.coeffRef(int(3 * n + i), int(3 * n + i)) += scene.mass(n) * 60 * 60;
  return A;
}

Eigen::VectorXd random_vector(Eigen::Index size, int seed) {
  std::mt19937_64 random{uint64_t(seed)};
  std::normal_distribution<double> normal;
  Eigen::VectorXd b(size);
  for (double& value : b) value = normal(random);
  return b;
}

/// Solves with the diagonal as preconditioner.
PcgResult solve(const Eigen::SparseMatrix<double>& A, const Eigen::VectorXd& b, double tolerance,
                int most, Eigen::VectorXd& x) {
  const Eigen::Index size = b.size();
  x = Eigen::VectorXd::Constant(size, 7);  // must not matter
  const Eigen::VectorXd diagonal = A.diagonal();
  PcgWork<double> work(size);
  return pcg(
      b.data(), x.data(), size, tolerance, most, work,
      [&](const double* p, double* Ap) {
        Eigen::Map<Eigen::VectorXd>(Ap, size) = A * Eigen::Map<const Eigen::VectorXd>(p, size);
      },
      [&](const double* r, double* z) {
        for (Eigen::Index k = 0; k < size; ++k) z[k] = r[k] / diagonal(k);
      });
}

TEST(Pcg, AgreesWithADirectSolverAndReportsItsTrueResidual) {
  for (int k = 0; k < 20; ++k) {
    const Eigen::SparseMatrix<double> A = system_matrix(k);
    const Eigen::VectorXd b = random_vector(A.rows(), k), reference = test::solve(A, b);
    Eigen::VectorXd x;
    EXPECT_TRUE(solve(A, b, 1e-13, 5000, x).converged);
    EXPECT_LE((x - reference).norm(), 1e-8 * reference.norm());
    const PcgResult loose = solve(A, b, 1e-6, 5000, x);
    const double residual = (b - A * x).norm() / b.norm();
    EXPECT_LE(loose.residual, 1e-6);
    EXPECT_NEAR(loose.residual, residual, 0.1 * residual);
  }
}

TEST(Pcg, EndsAfterAsManyStepsAsThereAreDistinctEigenvalues) {
  Eigen::SparseMatrix<double> A(30, 30);
  for (int k = 0; k < 30; ++k) A.insert(k, k) = 1;
  Eigen::VectorXd x;
  EXPECT_EQ(solve(A, random_vector(30, 1), 1e-12, 100, x).iterations, 1);
}

TEST(Pcg, ZeroRightHandSideNeedsNoStep) {
  const Eigen::SparseMatrix<double> A = system_matrix(0);
  Eigen::VectorXd x;
  const PcgResult result = solve(A, Eigen::VectorXd::Zero(A.rows()), 1e-10, 100, x);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_EQ(x.norm(), 0);
}

TEST(Pcg, SaysWhereItRanOutOfSteps) {
  const Eigen::SparseMatrix<double> A = system_matrix(4);
  Eigen::VectorXd x;
  const PcgResult result = solve(A, random_vector(A.rows(), 3), 1e-12, 3, x);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.iterations, 3);
  EXPECT_GT(result.residual, 1e-12);
}

TEST(Pcg, StopsAtNegativeCurvatureWithoutConverging) {
  Eigen::SparseMatrix<double> A(2, 2);
  A.insert(0, 0) = 1, A.insert(1, 1) = -3;
  PcgWork<double> work(2);
  const double b[2] = {1, 1};
  double x[2] = {5, 5};
  const auto copy = [](const double* r, double* z) { z[0] = r[0], z[1] = r[1]; };
  const PcgResult result = pcg(
      b, x, 2, 1e-10, 100, work,
      [](const double* p, double* Ap) { Ap[0] = p[0], Ap[1] = -3 * p[1]; }, copy);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_EQ(x[0], 0);
}

TEST(Pcg, EndsAtTheEdgeOfItsRadiusWithTheValueOfTheModel) {
  const Eigen::SparseMatrix<double> definite = system_matrix(3);
  const Eigen::VectorXd M = definite.diagonal(), b = random_vector(M.size(), 5);
  Eigen::SparseMatrix<double> A = definite;
  A.coeffRef(4, 4) -= 3 * M(4);  // one direction of negative curvature
  const auto size = M.size();
  const auto solve_within = [&](const Eigen::SparseMatrix<double>& matrix, double radius,
                                Eigen::VectorXd& x) {
    x.resize(size);
    PcgWork<double> work(size);
    return pcg(
        b.data(), x.data(), size, 1e-10, 5000, work,
        [&](const double* p, double* Ap) {
          Eigen::Map<Eigen::VectorXd>(Ap, size) =
              matrix * Eigen::Map<const Eigen::VectorXd>(p, size);
        },
        [&](const double* r, double* z) {
          for (Eigen::Index k = 0; k < size; ++k) z[k] = r[k] / M(k);
        },
        [] { return false; }, {.radius = radius});
  };
  const auto length = [&](const Eigen::VectorXd& x) { return std::sqrt(x.dot(M.cwiseProduct(x))); };
  // length of the solution without a bound
  Eigen::VectorXd x;
  solve_within(definite, PcgScalars::kUnbounded, x);
  const double whole = length(x);
  for (const double share : {0.1, 0.5, 0.9, 1.1, 10.0})
    for (const Eigen::SparseMatrix<double>* matrix : {&definite, &std::as_const(A)}) {
      const PcgResult result = solve_within(*matrix, share * whole, x);
      // only a definite matrix has its minimum within a larger radius
      const bool edge = share < 1 || matrix == &A;
      EXPECT_EQ(result.end.at_edge, edge) << share;
      EXPECT_NEAR(length(x), (edge ? share : 1) * whole, 1e-9 * whole);
      EXPECT_NEAR(std::sqrt(result.end.xx), length(x), 1e-9 * whole);
      const double model = x.dot(*matrix * x) / 2 - b.dot(x);
      EXPECT_NEAR(result.end.model, model, 1e-9 * std::abs(model));
      EXPECT_LT(model, 0);
    }
}

TEST(Pcg, ARadiusThatIsNotKnownIsTenTimesTheFirstDirection) {
  PcgWork<double> work(2);
  const double b[2] = {3, 4};
  double x[2];
  const PcgResult result = pcg(
      b, x, 2, 1e-10, 100, work, [](const double* p, double* Ap) { Ap[0] = -p[0], Ap[1] = -p[1]; },
      [](const double* r, double* z) { z[0] = r[0], z[1] = r[1]; }, [] { return false; },
      {.radius = 0});
  EXPECT_TRUE(result.end.at_edge);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_DOUBLE_EQ(x[0], 30);
  EXPECT_DOUBLE_EQ(x[1], 40);
}

}  // namespace
}  // namespace elastogen
