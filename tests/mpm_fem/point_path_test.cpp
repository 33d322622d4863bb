// SPDX-License-Identifier: Apache-2.0
// Paths of a metal's point against the equations in time that the steps are steps of: with l the
// velocity gradient, b = Fe Fe^T and n the direction of dev ln b,
//
//     db/dt = l b + b l^T - 2 p n b,   2 mu (n:l - p) = H p on the surface.

#include "mpm_fem/fem/plastic_point.hpp"
#include "tests/mpm_fem/return_maps.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace elastogen {
namespace {

using Matrix = Eigen::Matrix3d;

constexpr double kShear = 0.6;  // at the end of the path

Matrix logarithm_of(const Matrix& b) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(b);
  return eigen.eigenvectors() * eigen.eigenvalues().array().log().matrix().asDiagonal() *
         eigen.eigenvectors().transpose();
}

Matrix deviator_of(const Matrix& A) {
  return A - A.trace() / 3 * Matrix::Identity();
}

/// b and the flow while F = I + gamma e1 (x) e2 is sheared on.
struct Sheared {
  Matrix b = Matrix::Identity();
  double flow = 0;
};

/// d/dgamma on the surface, where the path stays once it is there.
Sheared rate_of(const VonMises<double, 3>& law, const Sheared& s) {
  Matrix l = Matrix::Zero();
  l(0, 1) = 1;
  const Matrix dev = deviator_of(logarithm_of(s.b)) / 2;
  const double size = dev.norm();
  Sheared rate{l * s.b + s.b * l.transpose(), 0};
  const Matrix n = dev / size;
  const double along = n(0, 1);
  rate.flow = 2 * law.mu * along / (2 * law.mu + law.hardening);
  rate.b -= 2 * rate.flow * n * s.b;
  return rate;
}

Sheared advanced(const Sheared& s, const Sheared& rate, double step) {
  return {s.b + step * rate.b, s.flow + step * rate.flow};
}

/// tau_12 at the end, by steps of the classical method of Runge and Kutta from the shear of yield
/// on.
double stress_of_equations(const VonMises<double, 3>& law) {
  Sheared s;
  // up to yield the point is elastic: gamma where 2 mu |dev ln b|/2 is the radius
  double lower = 0, upper = kShear;
  const auto elastic = [&](double gamma) {
    Matrix F = Matrix::Identity();
    F(0, 1) = gamma;
    return Matrix(F * F.transpose());
  };
  for (int k = 0; k < 60; ++k) {
    const double middle = (lower + upper) / 2;
    const double size = deviator_of(logarithm_of(elastic(middle))).norm() / 2;
    (2 * law.mu * size < law.radius ? lower : upper) = middle;
  }
  s.b = elastic(upper);
  constexpr int kSteps = 4000;
  const double step = (kShear - upper) / kSteps;
  for (int k = 0; k < kSteps; ++k) {
    const Sheared a = rate_of(law, s), b = rate_of(law, advanced(s, a, step / 2));
    const Sheared c = rate_of(law, advanced(s, b, step / 2));
    const Sheared d = rate_of(law, advanced(s, c, step));
    s.b += step / 6 * (a.b + 2 * b.b + 2 * c.b + d.b);
    s.flow += step / 6 * (a.flow + 2 * b.flow + 2 * c.flow + d.flow);
  }
  return law.mu * deviator_of(logarithm_of(s.b))(0, 1);
}

/// tau_12 at the end of the path in so many steps.
double stress_of_steps(const VonMises<double, 3>& law, int steps) {
  fem::PlasticPoint<VonMises<double, 3>> point{law, {}, identity<double>()};
  Mat3<double> F = identity<double>(), P{};
  for (int k = 1; k <= steps; ++k) {
    F(0, 1) = kShear * k / steps;
    P = point.stress(F);
    point.commit(F);
  }
  return times_transposed(P, F)(0, 1);
}

TEST(PointPath, ShearFollowsTheEquationsInTime) {
  for (const double hardening : {0.0, 0.1}) {
    const auto law =
        von_mises<double>(test::plastic_solid(), {.stress = 0.02, .hardening = hardening});
    const double exact = stress_of_equations(law);
    const double coarse = stress_of_steps(law, 400), fine = stress_of_steps(law, 800);
    // implicit steps of first order: half the step, half the error
    EXPECT_NEAR((coarse - exact) / (fine - exact), 2, 0.1) << "H " << hardening;
    EXPECT_NEAR(2 * fine - coarse, exact, 1e-6) << "H " << hardening;
    EXPECT_NEAR(fine, exact, 1e-3 * exact);
  }
}

TEST(PointPath, ABarFollowsItsStraightLinesInAnyNumberOfSteps) {
  const Material m = test::plastic_solid();
  const double strain = 0.3, H = test::kMetal.hardening, yield = test::kMetal.stress / m.young;
  const auto law = von_mises<double>(m, test::kMetal);
  const double stress = test::kMetal.stress + m.young * H / (m.young + H) * (strain - yield);
  const double flow = strain - stress / m.young;
  for (const int steps : {1, 7, 100}) {
    fem::PlasticPoint<VonMises<double, 3>> point{law, {}, identity<double>()};
    Mat3<double> F = identity<double>(), P{};
    for (int k = 1; k <= steps; ++k) {
      // the strains across in which nothing presses there: -nu elastic, -1/2 of the flow
      const double e = strain * k / steps,
                   plastic = std::max(0.0, (e - yield) * m.young / (m.young + H));
      const double across = -m.poisson * (e - plastic) - plastic / 2;
      for (int d = 0; d < 3; ++d) F(d, d) = std::exp(d == 0 ? e : across);
      P = point.stress(F);
      point.commit(F);
    }
    const Mat3<double> tau = times_transposed(P, F);
    EXPECT_NEAR(tau(0, 0), stress, 1e-9) << steps;
    EXPECT_NEAR(tau(1, 1), 0, 1e-9) << steps;
    // sqrt(3/2) |plastic strain| is that of the bar
    EXPECT_NEAR(point.history.flow * std::sqrt(2.0 / 3), flow, 1e-9) << steps;
  }
}

}  // namespace
}  // namespace elastogen
