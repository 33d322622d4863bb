// SPDX-License-Identifier: Apache-2.0
#include "network/solver.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/network/scenes.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr SolverMode kModes[] = {SolverMode::kQuasi, SolverMode::kNewton};

Scene small_beam(double poisson = 0.4) {
  return clamped_beam(12, 4, 4, 0.025, solid(1e5, poisson));
}

State after(const Scene& scene, int steps, const SolverOptions& options) {
  Solver solver(scene, options);
  State state = initial_state(scene);
  for (int k = 0; k < steps; ++k) {
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.converged) << solver_name(options.mode) << " step " << k << " residual "
                                  << report.residual;
  }
  return state;
}

double state_difference(const Scene& scene, const State& a, const State& b) {
  return relative_difference(displacement(scene, a), displacement(scene, b));
}

TEST(Solver, ModesReachTheSameState) {
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2}) {
    Scene scene = small_beam();
    scene.scheme = scheme;
    const SolverOptions quasi{.mode = SolverMode::kQuasi}, newton{.mode = SolverMode::kNewton};
    const State a = after(scene, 6, quasi), b = after(scene, 6, newton);
    EXPECT_LT(state_difference(scene, a, b), 1e-3);
    SolverOptions tight_quasi = quasi, tight_newton = newton;
    tight_quasi.tolerance = tight_newton.tolerance = 1e-8;
    const State c = after(scene, 6, tight_quasi), d = after(scene, 6, tight_newton);
    EXPECT_LT(state_difference(scene, c, d), 1e-6);
    EXPECT_LT(state_difference(scene, a, c), 1e-3);
  }
}

TEST(Solver, ConvergedMeansThatTheResidualIsBelowTheTolerance) {
  const Scene scene = small_beam();
  for (const SolverMode mode : kModes)
    for (const double tolerance : {1e-2, 1e-3, 1e-6})
      for (const int max_outer : {1, 400}) {
        Solver solver(scene, {.mode = mode, .tolerance = tolerance, .max_outer = max_outer});
        State state = initial_state(scene);
        for (int k = 0; k < 3; ++k) {
          const StepReport report = solver.step(state);
          EXPECT_EQ(report.converged, report.residual <= tolerance);
          if (max_outer == 400) {
            EXPECT_TRUE(report.converged);
          }
        }
      }
}

/// Element matrix of h^3/2 mean |grad u|^2 by 2x2x2 Gauss points, divided by h.
Eigen::Matrix<double, 8, 8> scalar_stiffness(bool centre_only) {
  Eigen::Matrix<double, 8, 8> K = Eigen::Matrix<double, 8, 8>::Zero();
  const double gauss = centre_only ? 0 : 1 / std::sqrt(3.0);
  for (int q = 0; q < 8; ++q) {
    Eigen::Matrix<double, 8, 3> gradient;
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 3; ++d) {
        gradient(c, d) = (c >> d & 1 ? 1 : -1);
        for (int e = 0; e < 3; ++e)
          if (e != d)
            gradient(c, d) *= (1 + (c >> e & 1 ? 1 : -1) * (q >> e & 1 ? gauss : -gauss)) / 2;
      }
    K += gradient * gradient.transpose() / 8;
  }
  return K;
}

/// The residual of implicit Euler on full voxels of log neo-Hookean, written out: P by inverse and
/// logarithm, the variance term by Gauss points.
double recomputed_residual(const Scene& scene, const State& before, const State& now) {
  const double h = scene.grid.h, mu = scene.materials[0].mu(), lambda = scene.materials[0].lambda();
  const double c_h = (mu + scene.materials[0].young / 2) / 2;
  const Eigen::Matrix<double, 8, 8> K =
      c_h * h * (scalar_stiffness(false) - scalar_stiffness(true));
  const int64_t nodes = scene.grid.node_count();
  std::vector<double> g(3 * size_t(nodes));
  // forces of the voxels
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) {
    Eigen::Matrix<double, 3, 8> x, X, sign;
    for (int c = 0; c < 8; ++c)
      for (int i = 0; i < 3; ++i) {
        x(i, c) = now.x(scene.grid.corners(v, c), i);
        X(i, c) = scene.grid.rest(scene.grid.corners(v, c), i);
        sign(i, c) = c >> i & 1 ? 1 : -1;
      }
    const Eigen::Matrix3d F = x * sign.transpose() / (4 * h), inverse = F.inverse().transpose();
    const Eigen::Matrix3d P = mu * (F - inverse) + lambda * std::log(F.determinant()) * inverse;
    const Eigen::Matrix<double, 3, 8> f = h * h / 4 * P * sign + (x - X) * K;
    for (int c = 0; c < 8; ++c)
      for (int i = 0; i < 3; ++i) g[size_t(3 * scene.grid.corners(v, c) + i)] += f(i, c);
  }
  // inertia and gravity, over the reference force
  double sum = 0, reference = 0;
  const double dt = scene.dt;
  for (int64_t n = 0; n < nodes; ++n) {
    if (scene.pinned(n)) continue;
    reference += 9.81 * 9.81 * scene.mass(n) * scene.mass(n);
    for (int i = 0; i < 3; ++i) {
      const double predictor =
          before.x(n, i) + dt * before.v(n, i) + dt * dt * scene.gravity[size_t(i)];
      const double force =
          g[size_t(3 * n + i)] + scene.mass(n) / (dt * dt) * (now.x(n, i) - predictor);
      sum += force * force;
    }
  }
  return std::sqrt(sum / reference);
}

TEST(Solver, ReportsTheResidualThatAnIndependentLoopFinds) {
  Scene scene = clamped_beam(12, 4, 4, 0.025, solid(1e5, 0.4));
  scene.hourglass = Hourglass::kVariance;
  finish_scene(scene);
  for (const SolverMode mode : kModes) {
    Solver solver(scene, {.mode = mode});
    State state = initial_state(scene);
    for (int k = 0; k < 5; ++k) {
      const State before = state;
      const StepReport report = solver.step(state);
      EXPECT_NEAR(recomputed_residual(scene, before, state) / report.residual, 1, 1e-6);
    }
  }
}

TEST(Solver, AStarvedStepIsADraftWithAnHonestNumber) {
  Scene scene = clamped_beam(12, 4, 4, 0.025, solid(1e5, 0.45));
  scene.hourglass = Hourglass::kVariance;
  finish_scene(scene);
  Solver solver(scene, {.mode = SolverMode::kQuasi, .max_outer = 1});
  State state = initial_state(scene);
  const State before = state;
  const StepReport report = solver.step(state);
  EXPECT_FALSE(report.converged);
  EXPECT_GT(report.residual, 1e-3);
  EXPECT_NEAR(recomputed_residual(scene, before, state) / report.residual, 1, 1e-6);
}

TEST(Solver, RestStaysAtRestToTheBit) {
  for (const SolverMode mode : {SolverMode::kAuto, SolverMode::kQuasi, SolverMode::kNewton})
    for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2})
      for (const bool clamped : {false, true}) {
        Scene scene = scene_on(ragged_grid(9, 7, 6, 0.1, 71), solid(1e5, 0.45));
        if (clamped) pin_below(scene, 0, 0);
        scene.scheme = scheme;
        finish_scene(scene);
        Solver solver(scene, {.mode = mode});
        State state = initial_state(scene);
        for (int k = 0; k < 20; ++k) EXPECT_TRUE(solver.step(state).converged);
        EXPECT_TRUE(state.x == scene.grid.rest);
        EXPECT_EQ(state.v, Array<double>(scene.grid.node_count(), 3));
      }
}

TEST(Solver, GivesTheSameBitsForOneAndTwoThreads) {
  for (const SolverMode mode : kModes) {
    Scene scene = scene_on(turned_bar_grid(0.5, 0.06, 0.025), solid(2e5, 0.4));
    pin_below(scene, 0, -0.12);
    scene.gravity = {0, -9.81, 0};
    finish_scene(scene);
    State states[2];
    for (int threads = 1; threads <= 2; ++threads) {
      const ThreadLimit control(threads);
      states[threads - 1] = after(scene, 20, {.mode = mode});
    }
    EXPECT_TRUE(states[0].x == states[1].x);
    EXPECT_TRUE(states[0].v == states[1].v);
  }
}

TEST(Solver, WithoutSkippingReachesTheSameState) {
  for (const double young : {1e3, 1e5}) {  // Courant numbers below and above the encoder's limit
    const Scene scene = clamped_beam(12, 4, 4, 0.025, solid(young, 0.3));
    const State a = after(scene, 8, {.skip = true}), b = after(scene, 8, {.skip = false});
    EXPECT_LT(state_difference(scene, a, b), 1e-3);
    EXPECT_GT(state_difference(scene, a, b), 0);  // two methods, not one
  }
}

TEST(Solver, SwitchesToDoubleWhereFloatCannotCertify) {
  const Scene soft = clamped_beam(12, 4, 4, 0.025, solid(1e5, 0.3));
  const Scene stiff = clamped_beam(12, 4, 4, 0.025, solid(1e8, 0.3));
  EXPECT_LT(float_floor(soft), 1e-3 / 3);
  EXPECT_GT(float_floor(stiff), 1e-3 / 3);
  const Scene* scenes[2] = {&soft, &stiff};
  for (int k = 0; k < 2; ++k) {
    Solver solver(*scenes[k], {.mode = SolverMode::kQuasi});
    State state = initial_state(*scenes[k]);
    const StepReport report = solver.step(state);
    EXPECT_EQ(report.float64, k == 1);
    EXPECT_TRUE(report.converged);
  }
}

TEST(Solver, AutoTakesNewtonForVeryStiffScenesOnly) {
  const double h = 0.025;
  const Scene soft = clamped_beam(4, 2, 2, h, solid(young_of_courant(90, h, 1.0 / 60), 0.3));
  const Scene stiff = clamped_beam(4, 2, 2, h, solid(young_of_courant(110, h, 1.0 / 60), 0.3));
  EXPECT_NEAR(courant_number(soft), 90, 1e-9);
  EXPECT_EQ(Solver(soft, {}).mode(), SolverMode::kQuasi);
  EXPECT_EQ(Solver(stiff, {}).mode(), SolverMode::kNewton);
}

TEST(Solver, ConvergesAtEveryStiffness) {
  for (const double C : {0.1, 1.4, 10.0, 100.0, 1000.0, 10000.0}) {
    const double h = 0.025;
    const Scene scene = clamped_beam(12, 4, 4, h, solid(young_of_courant(C, h, 1.0 / 60), 0.4));
    after(scene, 3, {});
  }
}

TEST(Solver, RefusesAStateOfAnotherScene) {
  const Scene scene = small_beam(), other = clamped_beam(4, 2, 2, 0.1, solid(1e5, 0.3));
  Solver solver(scene, {});
  State state = initial_state(other);
  EXPECT_THROW(solver.step(state), Error);
  EXPECT_THROW(Solver(scene, {.tolerance = 0}), Error);
  EXPECT_THROW(solver_from_name("magic"), Error);
  EXPECT_EQ(solver_from_name("newton"), SolverMode::kNewton);
}

TEST(Solver, RefusesANumberInTheStateThatIsNotFinite) {
  const Scene scene = small_beam();
  Solver solver(scene, {});
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL}) {
    State state = initial_state(scene);
    state.x(3, 1) = bad;
    EXPECT_THROW(solver.step(state), Error);
    state = initial_state(scene);
    state.v(3, 1) = bad;
    EXPECT_THROW(solver.step(state), Error);
    EXPECT_EQ(state.steps, 0);
    state = initial_state(scene);
    state.x_before = state.x;
    EXPECT_THROW(solver.step(state), Error);  // without the velocities before
    state.v_before = state.v;
    state.v_before(3, 1) = bad;
    EXPECT_THROW(solver.step(state), Error);
  }
  EXPECT_THROW(Solver(scene, {.tolerance = HUGE_VAL}), Error);
  EXPECT_THROW(Solver(scene, {.max_outer = -1}), Error);
}

TEST(Solver, KeepsTheStateWhereTheResultIsNotFinite) {
  const Scene scene = small_beam();
  Solver solver(scene, {});
  State state = initial_state(scene);
  state.v(scene.grid.node_count() - 1, 1) = 1e300;  // its square is not finite
  const Array<double> x = state.x;
  const StepReport report = solver.step(state);
  EXPECT_FALSE(report.finite);
  EXPECT_FALSE(report.converged);
  EXPECT_TRUE(state.x == x);
  EXPECT_EQ(state.steps, 0);
}

// strains of 1e-4 leave the energy with eps/strain of itself as rounding: the line search must know
TEST(Solver, SmallStrainsConvergeToTightTolerances) {
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    Scene scene = test::clamped_beam(40, 4, 4, 0.025, test::solid(1e8, 0));
    scene.dt = 2e-3;
    scene.scheme = TimeScheme::kBdf2;
    finish_scene(scene);
    Solver solver(scene, {.mode = mode, .tolerance = 1e-6});
    State state = initial_state(scene);
    for (int k = 0; k < 20; ++k) EXPECT_TRUE(solver.step(state).converged) << k;
  }
}

}  // namespace
}  // namespace elastogen::test
