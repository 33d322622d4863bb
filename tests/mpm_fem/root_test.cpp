// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/root.hpp"

#include "core/error.hpp"
#include "mpm_fem/solve/assembly.hpp"
#include "mpm_fem/solve/nonsymmetric_solver.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>

namespace elastogen::fem {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Flow along a chain of nodes that mixes components, with a cubic sink, and its known root:
/// r = A x + x^3 - (A x* + x*^3).
struct Chain {
  Assembly assembly;
  SparseMatrix A;
  Vector root, right;

  static Stencils links(int64_t nodes) {
    Stencils stencils;
    for (int32_t n = 0; n + 1 < nodes; ++n) {
      const int32_t ends[2] = {n, n + 1};
      stencils.add(ends, 2);
    }
    return stencils;
  }

  explicit Chain(int64_t nodes) : assembly(links(nodes), nodes) {
    A = pattern_of(assembly.stencils(), nodes);
    assembly.fit(A);
    assembly.add(
        [](int64_t, double* K) {
          Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> M(K);
          M.setZero();
          for (int i = 0; i < 3; ++i) {
            M(i, i) = 0.2, M(3 + i, 3 + i) = 3, M(3 + i, i) = -2;  // from the node before
            M(3 + i, 3 + (i + 1) % 3) = 0.5;
          }
        },
        A);
    for (int i = 0; i < 3; ++i) A.at(i, i) += 1;
    root = Vector::LinSpaced(A.rows(), 0, 9).array().sin();
    right = Vector::Zero(A.rows());
    right = residual(root);
  }

  Vector residual(const Vector& x) const {
    Vector r(x.size());
    multiply(A, x.data(), r.data());
    return r + x.array().cube().matrix() - right;
  }

  SparseMatrix jacobian(const double* x) const {
    SparseMatrix J = A;
    for (int64_t k = 0; k < J.rows(); ++k) J.at(k, k) += 3 * x[k] * x[k];
    return J;
  }
};

RootResult solve(const Chain& chain, NonsymmetricSolver& solver, const RootOptions& options,
                 Vector& x) {
  SparseMatrix J;
  RootFunction function;
  function.unknowns = x.size();
  function.residual = [&](const double* at, double* r) {
    Eigen::Map<Vector>(r, x.size()) = chain.residual(Eigen::Map<const Vector>(at, x.size()));
  };
  function.step = [&](const double* at, const double* r, double tolerance, double* step) {
    J = chain.jacobian(at);
    const Vector minus = -Eigen::Map<const Vector>(r, x.size());
    return solver.factor(J) && solver.solve(minus.data(), step, tolerance);
  };
  function.noise = [](const double*) { return 0.0; };
  return solve_root(function, options, x.data());
}

TEST(Root, OfANonsymmetricSystemIsFoundByLuAndByKrylov) {
  const Chain chain(40);
  for (const double operations : {1e9, 0.0}) {
    NonsymmetricSolver solver({.max_operations = operations});
    solver.reset(chain.A);
    EXPECT_EQ(solver.direct(), operations > 0);
    Vector x = Vector::Constant(chain.root.size(), 2);
    const RootResult result = solve(chain, solver, {.tolerance = 1e-11}, x);
    EXPECT_EQ(result.stop, RootStop::kConverged);
    EXPECT_LE(result.residual, 1e-11);
    EXPECT_LT((x - chain.root).norm(), 1e-10);
    EXPECT_LE(result.iterations, 12);
    EXPECT_EQ(solver.iterations() == 0, operations > 0);
  }
}

/// A problem of one or few unknowns with a dense Jacobian.
RootResult solve_dense(const std::function<Vector(const Vector&)>& r,
                       const std::function<Matrix(const Vector&)>& J, Vector& x,
                       const RootOptions& options, double noise = 0) {
  const auto view = [&](const double* p) { return Eigen::Map<const Vector>(p, x.size()); };
  RootFunction function;
  function.unknowns = x.size();
  function.residual = [&](const double* at, double* out) {
    Eigen::Map<Vector>(out, x.size()) = r(view(at));
  };
  function.step = [&](const double* at, const double* residual, double, double* step) {
    const Eigen::FullPivLU<Matrix> lu(J(view(at)));
    Eigen::Map<Vector>(step, x.size()) = -lu.solve(view(residual));
    return lu.isInvertible();
  };
  function.noise = [&](const double*) { return noise; };
  return solve_root(function, options, x.data());
}

/// Rotation by about a quarter turn: r . J r < 0 for no x, but r is no gradient.
const auto kSpiral = [](const Vector& x) -> Vector {
  return Vector{{x(0) - 2 * x(1) + x(0) * x(0), 2 * x(0) + x(1)}};
};
const auto kSpiralJacobian = [](const Vector& x) -> Matrix {
  return Matrix{{1 + 2 * x(0), -2}, {2, 1}};
};
const auto kArctangent = [](const Vector& x) -> Vector { return x.array().atan(); };
const auto kArctangentSlope = [](const Vector& x) -> Matrix {
  return (1 / (1 + x.array().square())).matrix().asDiagonal();
};

TEST(Root, ConvergesQuadratically) {
  Vector x{{0.3, -0.2}};
  double before = kSpiral(x).norm();
  for (int k = 0; k < 4; ++k) {
    solve_dense(kSpiral, kSpiralJacobian, x, {.tolerance = 0, .max_iterations = 1});
    EXPECT_LE(kSpiral(x).norm(), 1 * before * before);
    before = kSpiral(x).norm();
  }
  EXPECT_LT(before, 1e-12);
}

TEST(Root, BacktracksWhereTheWholeStepOvershoots) {
  Vector x{{3.0}};  // beyond 1.39 whole steps diverge
  const RootResult result = solve_dense(kArctangent, kArctangentSlope, x, {.tolerance = 1e-12});
  EXPECT_EQ(result.stop, RootStop::kConverged);
  EXPECT_GT(result.evaluations, result.iterations + 1);
  EXPECT_NEAR(x(0), 0, 1e-12);
}

TEST(Root, SaysWhyItEnded) {
  Vector x{{3.0}};
  EXPECT_EQ(
      solve_dense(kArctangent, kArctangentSlope, x, {.tolerance = 1e-12, .max_iterations = 2}).stop,
      RootStop::kIterations);

  // a Jacobian of the wrong sign
  x = Vector{{3.0}};
  const auto rising = [](const Vector& y) -> Matrix { return -kArctangentSlope(y); };
  EXPECT_EQ(solve_dense(kArctangent, rising, x, {.tolerance = 1e-12}).stop, RootStop::kLineSearch);
  EXPECT_EQ(x(0), 3);

  const auto flat = [](const Vector& y) -> Matrix { return Matrix::Zero(y.size(), y.size()); };
  EXPECT_EQ(solve_dense(kArctangent, flat, x, {.tolerance = 1e-12}).stop, RootStop::kSingular);
  EXPECT_EQ(stop_name(RootStop::kSingular), "singular");

  // no root at all: x^2 + 1
  x = Vector{{0.5}};
  const RootResult none =
      solve_dense([](const Vector& y) -> Vector { return y.array().square() + 1; },
                  [](const Vector& y) -> Matrix { return 2 * y.asDiagonal().toDenseMatrix(); }, x,
                  {.tolerance = 1e-12});
  EXPECT_TRUE(none.stop == RootStop::kLineSearch || none.stop == RootStop::kSingular ||
              none.stop == RootStop::kIterations);
  EXPECT_GE(none.residual, 1);

  x = Vector{{NAN}};
  EXPECT_EQ(solve_dense(kArctangent, kArctangentSlope, x, {}).stop, RootStop::kNotFinite);
}

TEST(Root, ReportsTheRoundingErrorThatItEndsAt) {
  // a residual that is known to 1e-6 only
  const auto rough = [](const Vector& x) -> Vector {
    return kArctangent(x).array() + 1e-6 * (1e9 * x.array()).sin();
  };
  Vector x{{1.0}};
  const RootResult result = solve_dense(rough, kArctangentSlope, x, {.tolerance = 1e-14}, 2e-6);
  EXPECT_EQ(result.stop, RootStop::kRoundOff);
  EXPECT_LE(result.residual, result.noise);
}

TEST(Root, StaysAtARootAndTakesNothing) {
  Vector x{{0.0, 0.0}};
  const RootResult result = solve_dense(kSpiral, kSpiralJacobian, x, {.tolerance = 0});
  EXPECT_EQ(result.stop, RootStop::kConverged);
  EXPECT_EQ(result.iterations, 0);
  Vector none(0);
  EXPECT_EQ(solve_dense([](const Vector& y) { return y; }, kSpiralJacobian, none, {}).stop,
            RootStop::kConverged);
}

}  // namespace
}  // namespace elastogen::fem
