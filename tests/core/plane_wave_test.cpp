// SPDX-License-Identifier: Apache-2.0
// Plane waves along a row of voxels whose other displacement components are held: bulk and shear
// speed of the assembled operator with the time schemes of the solvers.

#include "core/time_scheme.hpp"
#include "tests/support/element_assembly.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

/// A row of voxels with h = E = rho = 1 that moves in one component only, stepped by BDF2.
class Row {
 public:
  Row(int cells, int component, double poisson, double dt)
      : scene(test::box_scene(cells, 1, 1, 1, {"test", Law::kNeoHookean, 1, poisson, 1})),
        u(Eigen::VectorXd::Zero(3 * scene.grid.node_count())),
        v(u),
        component_(component) {
    scene.scheme = TimeScheme::kBdf2;
    scene.dt = dt;
    K_ = test::rest_stiffness(scene);
    for (int dof = 0; dof < u.size(); ++dof)
      if (dof % 3 != component) held_[dof] = 0;
  }

  /// Place along the row of a node and its degree of freedom.
  double place(int64_t node) const { return scene.grid.rest(node, 0); }
  int dof(int64_t node) const { return int(3 * node) + component_; }

  void step() {
    State state;
    if (u_before_.size() > 0) state.x_before = Array<double>(1, 3);
    const StepScheme s = step_scheme(scene, state);
    if (u_before_.size() == 0) u_before_ = u, v_before_ = v;
    Eigen::SparseMatrix<double> A = K_;
    Eigen::VectorXd b(u.size());
    for (int k = 0; k < u.size(); ++k) {
      const double inertia = s.a0 * scene.mass(k / 3) / (s.dt * s.dt);
      A.coeffRef(k, k) += inertia;
      b(k) = inertia * (u(k) + predicted_motion(s, u(k), v(k), u_before_(k), v_before_(k), 0));
    }
    const Eigen::VectorXd next = test::solve(A, b, held_);
    Eigen::VectorXd speed(u.size());
    for (int k = 0; k < u.size(); ++k) speed(k) = velocity_after(s, next(k), u(k), u_before_(k));
    u_before_ = u, v_before_ = v, u = next, v = speed;
    time += s.dt;
  }

  Scene scene;
  Eigen::VectorXd u, v;
  double time = 0;

 private:
  int component_;
  Eigen::SparseMatrix<double> K_;
  Eigen::VectorXd u_before_, v_before_;
  std::map<int, double> held_;
};

/// Time at which a pulse has come from cell 20 to cell 60.
double arrival(int component, double poisson, double speed, double dt) {
  constexpr double kStart = 20, kEnd = 60, kWidth = 5;
  Row row(80, component, poisson, dt);
  int watched = -1;
  for (int64_t n = 0; n < row.scene.grid.node_count(); ++n) {
    // u = f(x - c t), v = -c f'
    const double s = (row.place(n) - kStart) / kWidth, f = std::exp(-s * s / 2);
    row.u(row.dof(n)) = f;
    row.v(row.dof(n)) = speed * f * s / kWidth;
    if (row.place(n) == kEnd) watched = row.dof(n);
  }
  double largest = 0, result = 0;
  while (row.time * speed < 55) {
    row.step();
    if (row.u(watched) > largest) largest = row.u(watched), result = row.time;
  }
  return result;
}

/// Steps in which a standing wave of 100 cells falls from its height to zero: a quarter period.
double quarter_period(int component, double poisson, double dt) {
  constexpr int kCells = 50;
  Row row(kCells, component, poisson, dt);
  for (int64_t n = 0; n < row.scene.grid.node_count(); ++n)
    row.u(row.dof(n)) = std::cos(std::numbers::pi * row.place(n) / kCells);
  double before = 1, now = 1;
  while (now > 0) {
    before = now;
    row.step();
    now = row.u(row.dof(0));
  }
  return row.time - dt * now / (now - before);
}

TEST(PlaneWave, BulkAndShearWavesHaveTheirSpeeds) {
  for (const double poisson : {0.3, 0.45}) {
    const double mu = 1 / (2 * (1 + poisson)), lambda = 2 * mu * poisson / (1 - 2 * poisson);
    const double speeds[2] = {std::sqrt(lambda + 2 * mu), std::sqrt(mu)};
    for (const int component : {0, 1}) {
      const double c = speeds[component];
      const double time = arrival(component, poisson, c, 0.25 / c);
      const double period = 4 * quarter_period(component, poisson, 1 / c);
      printf("nu %.2f, %s: 40 cells in %.2f cells/c, wave of 100 cells in %.2f\n", poisson,
             component == 0 ? "bulk" : "shear", time * c, period * c);
      EXPECT_NEAR(time * c, 40, 1.25);  // one cell and one step
      EXPECT_NEAR(period * c, 100, 2);
    }
  }
}

}  // namespace
}  // namespace elastogen
