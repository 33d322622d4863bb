// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/nonsymmetric_solver.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "mpm_fem/solve/assembly.hpp"
#include "tests/mpm_fem/bodies.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace elastogen::fem {
namespace {

using Vector = Eigen::VectorXd;

/// Random matrices, not symmetric, of the elements of a box.
SparseMatrix assembled(int nx, int ny, int nz, double shift) {
  const ElementMesh mesh = test::block(Element::kHex, nx, ny, nz, 1);
  Assembly assembly(stencils_of(mesh.elements), mesh.rest.rows());
  SparseMatrix A = pattern_of(assembly.stencils(), mesh.rest.rows());
  assembly.fit(A);
  assembly.add(
      [&](int64_t e, double* K) {
        std::mt19937 random{uint32_t(e)};
        std::normal_distribution<double> normal;
        for (int k = 0; k < 24 * 24; ++k) K[k] = normal(random) + (k % 25 == 0 ? shift : 0);
      },
      A);
  return A;
}

Vector solution(const SparseMatrix& A, const Vector& b) {
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(A.rows(), A.rows());
  for (int64_t r = 0; r < A.rows(); ++r)
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k)
      dense(r, A.column[size_t(k)]) = A.value[size_t(k)];
  return dense.partialPivLu().solve(b);
}

TEST(NonsymmetricSolver, LuAndKrylovAgreeWithEigen) {
  const SparseMatrix A = assembled(3, 3, 2, 20);
  const Vector b = Vector::LinSpaced(A.rows(), -1, 1), exact = solution(A, b);
  for (const double operations : {1e12, 0.0}) {
    NonsymmetricSolver solver({.max_operations = operations});
    solver.reset(A);
    ASSERT_TRUE(solver.factor(A));
    Vector x(A.rows());
    ASSERT_TRUE(solver.solve(b.data(), x.data(), 1e-13));
    EXPECT_LT((x - exact).norm(), 1e-11 * exact.norm()) << operations;
  }
}

TEST(NonsymmetricSolver, BlockInverseSolvesWhatHasBlocksOnly) {
  SparseMatrix A = pattern_of({}, 5);
  std::mt19937 random{3};
  std::normal_distribution<double> normal;
  for (double& a : A.value) a = normal(random);
  const Vector b = Vector::LinSpaced(A.rows(), -1, 1);
  NonsymmetricSolver solver({.max_entries = 0});
  solver.reset(A);
  EXPECT_FALSE(solver.direct());
  ASSERT_TRUE(solver.factor(A));
  Vector x(A.rows());
  ASSERT_TRUE(solver.solve(b.data(), x.data(), 1e-12));
  EXPECT_EQ(solver.iterations(), 1);
  EXPECT_LT((x - solution(A, b)).norm(), 1e-11 * x.norm());
}

TEST(NonsymmetricSolver, SaysWhatIsSingularAndGoesOn) {
  const SparseMatrix A = assembled(2, 2, 1, 20);
  const Vector b = Vector::Ones(A.rows()), exact = solution(A, b);
  Vector x(A.rows());
  for (const int64_t entries : {1'000'000, 0}) {
    NonsymmetricSolver solver({.max_entries = entries});
    solver.reset(A);
    SparseMatrix singular = A;
    for (int32_t k = A.start[7]; k < A.start[8]; ++k) singular.value[size_t(k)] = 0;
    EXPECT_FALSE(solver.factor(singular));
    SparseMatrix broken = A;
    broken.at(4, 4) = NAN;
    EXPECT_FALSE(solver.factor(broken));
    ASSERT_TRUE(solver.factor(A));
    ASSERT_TRUE(solver.solve(b.data(), x.data(), 1e-13));
    EXPECT_LT((x - exact).norm(), 1e-11 * exact.norm());
  }
}

TEST(NonsymmetricSolver, TakesAnotherPatternAfterReset) {
  const SparseMatrix A = assembled(2, 1, 1, 20), B = assembled(2, 2, 1, 20);
  for (const int64_t entries : {1'000'000, 0}) {
    NonsymmetricSolver solver({.max_entries = entries});
    EXPECT_THROW(solver.factor(A), Error);  // no pattern yet
    for (const SparseMatrix* matrix : {&A, &B}) {
      solver.reset(*matrix);
      ASSERT_TRUE(solver.factor(*matrix));
      const Vector b = Vector::Ones(matrix->rows());
      Vector x(matrix->rows());
      ASSERT_TRUE(solver.solve(b.data(), x.data(), 1e-13));
      EXPECT_LT((x - solution(*matrix, b)).norm(), 1e-11 * x.norm());
    }
    EXPECT_THROW(solver.factor(A), Error);
  }
}

TEST(NonsymmetricSolver, TakesNoNodes) {
  const SparseMatrix none = pattern_of({}, 0);
  for (const int64_t entries : {1'000'000, -1}) {
    NonsymmetricSolver solver({.max_entries = entries});
    solver.reset(none);
    EXPECT_TRUE(solver.factor(none));
    double nothing = 0;
    EXPECT_TRUE(solver.solve(&nothing, &nothing, 1e-12));
  }
}

TEST(SparseLu, HasTheSameBitsOnAnyNumberOfThreads) {
  const SparseMatrix A = assembled(6, 5, 5, 20);
  const std::vector<double> b(size_t(A.rows()), 1);
  std::vector<double> x(b), again(b);
  SparseLu lu(A), other(A);
  ASSERT_TRUE(lu.factor(A));
  lu.solve(b.data(), x.data());
  const ThreadLimit limit(1);
  ASSERT_TRUE(other.factor(A));
  other.solve(b.data(), again.data());
  EXPECT_EQ(x, again);
  EXPECT_GT(lu.operations(), 1e5);
}

TEST(SparseLu, RefusesToSolveWithoutFactors) {
  const SparseMatrix A = assembled(1, 1, 1, 20);
  SparseLu lu(A);
  std::vector<double> b(size_t(A.rows()), 1), x(b);
  EXPECT_THROW(lu.solve(b.data(), x.data()), Error);
  EXPECT_THROW(lu.factor(assembled(2, 1, 1, 20)), Error);
}

}  // namespace
}  // namespace elastogen::fem
