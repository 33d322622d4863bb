// SPDX-License-Identifier: Apache-2.0
// Starts of steps: pieces with a pin start from their predictor or by their velocities.
#include "network/step/predictor.hpp"

#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

TEST(Predictor, ExtrapolationMovesFreeNodesOfPinnedPiecesAlone) {
  Scene scene = clamped_beam(6, 2, 2, 0.1, solid(1e5, 0.3));
  State state = initial_state(scene);
  state.x_before = state.x, state.v_before = state.v;
  // velocities now and before, different at each node
  for (int64_t n = 0; n < state.x.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      state.v(n, d) = 1 + double(n) + 0.1 * d;
      state.v_before(n, d) = 2 - 0.5 * double(n);
    }
  const StepScheme bdf2{TimeScheme::kBdf2, scene.dt, 2.25};
  const Predictor predictor(scene);
  for (int order = 1; order <= 2; ++order) {
    // both orders written out; pinned nodes do not move
    std::vector<double> u(size_t(state.x.size()), 7);
    predictor.extrapolate(state, bdf2, order, u.data());
    int64_t held = 0;
    for (int64_t n = 0; n < state.x.rows(); ++n)
      for (int d = 0; d < 3; ++d) {
        const double v = state.v(n, d), change = order == 1 ? 0 : (v - state.v_before(n, d)) / 2;
        const double way = scene.pinned(n) ? 0 : scene.dt * (v + change);
        held += scene.pinned(n);
        ASSERT_NEAR(u[size_t(3 * n + d)], state.x(n, d) - scene.grid.rest(n, d) + way, 1e-12);
      }
    EXPECT_GT(held, 0);
  }
}

TEST(Predictor, ExtrapolationLeavesFreePiecesAlone) {
  Scene scene = scene_on(make_box(6, 2, 2, 0.1), solid(1e5, 0.3));
  finish_scene(scene);
  State state = initial_state(scene, {.velocity = {1, 2, 3}});
  std::vector<double> u(size_t(state.x.size()), 7);
  Predictor(scene).extrapolate(state, {TimeScheme::kEuler, scene.dt, 1}, 1, u.data());
  for (const double value : u) ASSERT_EQ(value, 7);
}

/// Outer iterations of a step to 1e-3 from where `steps` steps have brought the scene to rest.
int iterations_at_rest(Scene scene, SolverMode mode, double dt, int steps) {
  scene.dt = dt;  // Euler damps vibrations at once
  scene.scheme = TimeScheme::kEuler;
  scene.gravity = {0, -9.81, 0};
  finish_scene(scene);
  Solver solver(scene, {.mode = mode, .tolerance = 1e-6});
  State state = initial_state(scene);
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(solver.step(state).converged) << k;
  Solver rough(scene, {.mode = mode, .tolerance = 1e-3});
  const StepReport report = rough.step(state);
  EXPECT_TRUE(report.converged);
  return report.outer;
}

/// A body that hangs still needs nothing but the certificate: its velocities are 0, and forces that
/// hold it are there already. From the predictor, which lets it fall, it takes several iterations.
TEST(Predictor, ABodyThatHangsStillTakesNoIterations) {
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    Scene scene = scene_on(make_box(10, 3, 3, 0.05), solid(2e5, 0.3));
    pin_below(scene, 0, 0.01);
    EXPECT_EQ(iterations_at_rest(std::move(scene), mode, 0.5, 40), 0) << solver_name(mode);
  }
}

TEST(Predictor, ABodyThatLiesStillTakesFewIterations) {
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    Scene scene = scene_on(make_box(5, 4, 5, 0.05), solid(2e5, 0.3));
    scene.colliders = {half_space({0, 1, 0}, 0, 0.5)};
    scene.surface = face_points(scene.grid);
    EXPECT_LE(iterations_at_rest(std::move(scene), mode, 0.05, 60), 1) << solver_name(mode);
  }
}

}  // namespace
}  // namespace elastogen::test
