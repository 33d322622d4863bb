// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/newton.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace elastogen::fem {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// A function with its derivatives as dense matrices.
struct DenseProblem {
  std::function<double(const Vector&)> value;
  std::function<Vector(const Vector&)> gradient;
  std::function<Matrix(const Vector&)> hessian;
};

/// The Hessian with its eigenvalues raised to at least `least`.
Matrix projected_hessian(const Matrix& H, double least) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(H);
  const Matrix& V = eigen.eigenvectors();
  return V * eigen.eigenvalues().cwiseMax(least).asDiagonal() * V.transpose();
}

NewtonResult minimise(const DenseProblem& f, Vector& x,
                      const NewtonOptions& options = {.tolerance = 1e-9}, double noise = 0) {
  const auto view = [&](const double* p) { return Eigen::Map<const Vector>(p, x.size()); };
  NewtonFunction function;
  function.unknowns = x.size();
  function.evaluate = [&](const double* at, double* gradient) {
    Eigen::Map<Vector>(gradient, x.size()) = f.gradient(view(at));
    const double value = f.value(view(at));
    return NewtonValue{value, 1e-15 * std::abs(value)};
  };
  function.step = [&](const double* at, const double* gradient, TangentKind kind, double,
                      double* step) {
    Matrix H = f.hessian(view(at));
    if (kind == TangentKind::kProjected) H = projected_hessian(H, 1e-3);
    const Eigen::LLT<Matrix> llt(H);
    if (!H.allFinite() || llt.info() != Eigen::Success) return false;
    Eigen::Map<Vector>(step, x.size()) = -llt.solve(view(gradient));
    return true;
  };
  function.gradient_noise = [&](const double*) { return noise; };
  return minimise(function, options, x.data());
}

/// (1 - x)^2 + 100 (y - x^2)^2, least at (1, 1).
const DenseProblem kRosenbrock = {
    [](const Vector& x) { return std::pow(1 - x(0), 2) + 100 * std::pow(x(1) - x(0) * x(0), 2); },
    [](const Vector& x) -> Vector {
      const double d = x(1) - x(0) * x(0);
      return Vector{{-2 * (1 - x(0)) - 400 * x(0) * d, 200 * d}};
    },
    [](const Vector& x) -> Matrix {
      return Matrix{{2 - 400 * (x(1) - 3 * x(0) * x(0)), -400 * x(0)}, {-400 * x(0), 200}};
    }};

/// sum (x_i^2 - 1)^2/4 + x_i/10: indefinite where a component is small.
const DenseProblem kWells = {
    [](const Vector& x) { return ((x.array().square() - 1).square() / 4 + x.array() / 10).sum(); },
    [](const Vector& x) -> Vector { return x.array() * (x.array().square() - 1) + 0.1; },
    [](const Vector& x) -> Matrix { return (3 * x.array().square() - 1).matrix().asDiagonal(); }};

TEST(Newton, FindsTheMinimumOfRosenbrocksFunction) {
  Vector x{{-1.2, 1}};
  const NewtonResult result = minimise(kRosenbrock, x);
  EXPECT_EQ(result.stop, NewtonStop::kConverged);
  EXPECT_LE(result.residual, 1e-9);
  EXPECT_LT((x - Vector{{1, 1}}).norm(), 1e-9);
  EXPECT_LE(result.iterations, 25);  // textbooks print 21 with another line search
  EXPECT_EQ(result.projected, 0);
  EXPECT_GT(result.evaluations, result.iterations);
}

TEST(Newton, LeavesAMaximumWithTheProjectedHessian) {
  Vector x{{0.05, -0.03, 1.2, -0.9}};
  const NewtonResult result = minimise(kWells, x);
  EXPECT_EQ(result.stop, NewtonStop::kConverged);
  EXPECT_GT(result.projected, 0);
  EXPECT_LT(result.projected, result.iterations);  // near the minimum the exact one
  EXPECT_GT(kWells.hessian(x).diagonal().minCoeff(), 1);
  EXPECT_LT(kWells.gradient(x).norm(), 1e-9);
}

TEST(Newton, ConvergesQuadratically) {
  Vector x{{1.2, -1.2, 1.1}};
  double before = kWells.gradient(x).norm();
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(minimise(kWells, x, {.tolerance = 0, .max_iterations = 1}).iterations, 1);
    const double now = kWells.gradient(x).norm();
    EXPECT_LT(now, 2 * before * before);
    before = now;
  }
}

TEST(Newton, SaysWhyItEnded) {
  Vector x{{-1.2, 1}};
  EXPECT_EQ(minimise(kRosenbrock, x, {.tolerance = 1e-9, .max_iterations = 3}).stop,
            NewtonStop::kIterations);

  DenseProblem never = kWells;
  never.hessian = [](const Vector& y) { return Matrix::Constant(y.size(), y.size(), NAN); };
  EXPECT_EQ(minimise(never, x).stop, NewtonStop::kIndefinite);

  DenseProblem rising = kWells;  // a gradient of the wrong sign
  rising.gradient = [](const Vector& y) -> Vector { return -kWells.gradient(y); };
  x = Vector{{2, 2}};
  EXPECT_EQ(minimise(rising, x).stop, NewtonStop::kLineSearch);
  EXPECT_EQ(x, (Vector{{2, 2}}));

  x = Vector{{NAN, 1}};
  EXPECT_EQ(minimise(kRosenbrock, x).stop, NewtonStop::kNotFinite);
}

TEST(Newton, ReportsTheRoundingErrorThatItEndsAt) {
  // a gradient that is known to 1e-6 only
  DenseProblem rough = kWells;
  rough.gradient = [](const Vector& x) -> Vector {
    return kWells.gradient(x).array() + 1e-6 * (1e9 * x.array()).sin();
  };
  Vector x{{1.3, -1.3}};
  const NewtonResult result = minimise(rough, x, {.tolerance = 1e-12}, 2e-6);
  EXPECT_EQ(result.stop, NewtonStop::kRoundOff);
  EXPECT_GT(result.residual, 1e-12);
  EXPECT_LE(result.residual, result.noise);
  EXPECT_LE(result.iterations, 15);
}

TEST(Newton, StaysAtAMinimum) {
  Vector x{{1, 1}};
  const NewtonResult result = minimise(kRosenbrock, x, {.tolerance = 0});
  EXPECT_EQ(result.stop, NewtonStop::kConverged);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_EQ(x, (Vector{{1, 1}}));
}

}  // namespace
}  // namespace elastogen::fem
