// SPDX-License-Identifier: Apache-2.0
// Runs on the device against those on the CPU. Nothing is here in builds without CUDA; skipped
// where there is no device.

#ifdef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/solver.hpp"
#include "tests/network/step/moving_scenes.hpp"

namespace elastogen::test {
namespace {

struct Outcome {
  State state;
  int converged = 0;
  std::vector<double> residual;
  StepReport report;
};

Outcome run_clip(const Scene& scene, SolverOptions options, Device device,
                 const StartMotion& motion, int steps) {
  options.device = device;
  Solver solver(scene, options);
  Outcome result;
  solver.begin(initial_state(scene, motion));
  for (int k = 0; k < steps; ++k) {
    result.report = solver.advance();
    result.converged += result.report.converged;
  }
  solver.read(result.state);
  const Span<const double> g = solver.residual();
  result.residual.assign(g.data, g.data + g.size());
  return result;
}

TEST_F(OnCard, RunsEndInTheStatesOfTheHost) {
  constexpr int kSteps = 24;
  const StartMotion spinning{.velocity = {0.5, 1, 0}, .spin = {2, 3, -1}};
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, scheme ", int(scene.scheme)));
    const SolverOptions options{.mode = SolverMode::kQuasi, .tolerance = 1e-6};
    const Outcome a = run_clip(scene, options, Device::kCpu, spinning, kSteps);
    const Outcome b = run_clip(scene, options, Device::kCuda, spinning, kSteps);
    EXPECT_EQ(a.converged, kSteps);
    EXPECT_EQ(b.converged, kSteps);
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-5);
    EXPECT_NEAR(b.report.energy.kinetic, a.report.energy.kinetic, 1e-4 * a.report.energy.kinetic);
    EXPECT_NEAR(b.report.energy.elastic, a.report.energy.elastic, 1e-3 * a.report.energy.elastic);
    EXPECT_NEAR(b.report.min_j, a.report.min_j, 1e-4);
    EXPECT_LE(norm(b.residual), 1e-6 * reference_force(scene));
    EXPECT_GT(norm(b.residual), 0);
  }
}

TEST_F(OnCard, RunsTakeTheIterationsOfTheHost) {
  for (const Scene& scene : scenes()) {
    const SolverOptions options{.mode = SolverMode::kQuasi};
    const Outcome a = run_clip(scene, options, Device::kCpu, {}, 6);
    const Outcome b = run_clip(scene, options, Device::kCuda, {}, 6);
    EXPECT_EQ(b.converged, 6);
    EXPECT_EQ(b.report.float64, a.report.float64);
    EXPECT_NEAR(b.report.inner, a.report.inner, 2 + a.report.inner / 5);
  }
}

TEST_F(OnCard, TablesOfManyChunksOfAnUploadArriveWhole) {
  // 33 MB of modes and 9 MB of rest positions
  constexpr double kEdge = 0.02;
  const Scene scene =
      clamped_beam(90, 70, 61, kEdge, solid(young_of_courant(8, kEdge, 1.0 / 60), 0.4));
  const SolverOptions options{.mode = SolverMode::kQuasi, .tolerance = 1e-5};
  const Outcome a = run_clip(scene, options, Device::kCpu, {}, 2);
  const Outcome b = run_clip(scene, options, Device::kCuda, {}, 2);
  EXPECT_EQ(a.converged, 2);
  EXPECT_EQ(b.converged, 2);
  EXPECT_NEAR(b.report.inner, a.report.inner, 2 + a.report.inner / 5);
  EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-4);
}

TEST_F(OnCard, LongRunsRepeatToTheBit) {
  const Scene scene = three_blocks(TimeScheme::kBdf2);
  const SolverOptions options{.mode = SolverMode::kQuasi};
  const StartMotion spinning{.spin = {1, 2, 3}};
  const Outcome a = run_clip(scene, options, Device::kCuda, spinning, 200);
  const Outcome b = run_clip(scene, options, Device::kCuda, spinning, 200);
  EXPECT_GE(a.converged, 199);
  EXPECT_EQ(a.state.x, b.state.x);
  EXPECT_EQ(a.state.v, b.state.v);
  EXPECT_EQ(a.residual, b.residual);
}

TEST_F(OnCard, PiecesFallAsOneMassPointWhateverTheTolerance) {
  const Scene scene = falling_bar(TimeScheme::kEuler);
  const StartMotion spinning{.spin = {3, 4, 5}};
  constexpr int kSteps = 50;
  const Outcome r = run_clip(scene, {.mode = SolverMode::kQuasi, .tolerance = 0.1}, Device::kCuda,
                             spinning, kSteps);
  const State start = initial_state(scene, spinning);
  const double t = kSteps * scene.dt;
  double mass = 0;
  Vec3 moved = {}, gained = {};
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    mass += scene.mass(n);
    for (int d = 0; d < 3; ++d) {
      moved[size_t(d)] += scene.mass(n) * (r.state.x(n, d) - start.x(n, d));
      gained[size_t(d)] += scene.mass(n) * (r.state.v(n, d) - start.v(n, d));
    }
  }
  for (size_t d = 0; d < 3; ++d) {
    EXPECT_NEAR(moved[d], mass * scene.gravity[d] * t * (t + scene.dt) / 2, 1e-11 * mass);
    EXPECT_NEAR(gained[d], mass * scene.gravity[d] * t, 1e-11 * mass);
  }
}

TEST_F(OnCard, NewtonEndsInTheStatesOfTheHost) {
  constexpr int kSteps = 12;
  const StartMotion spinning{.velocity = {0.5, 1, 0}, .spin = {2, 3, -1}};
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, scheme ", int(scene.scheme)));
    const SolverOptions options{.mode = SolverMode::kNewton, .tolerance = 1e-6};
    const Outcome a = run_clip(scene, options, Device::kCpu, spinning, kSteps);
    const Outcome b = run_clip(scene, options, Device::kCuda, spinning, kSteps);
    EXPECT_EQ(a.converged, kSteps);
    EXPECT_EQ(b.converged, kSteps);
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-5);
    // the card solves larger levels of the V-cycle: its iterations are others, and not more
    EXPECT_NEAR(b.report.outer, a.report.outer, 2);
    EXPECT_LE(b.report.inner, 3 + a.report.inner + a.report.inner / 5);
  }
}

TEST_F(OnCard, NewtonRepeatsToTheBit) {
  const Scene scene = three_blocks(TimeScheme::kBdf2);
  const SolverOptions options{.mode = SolverMode::kNewton};
  const StartMotion spinning{.spin = {1, 2, 3}};
  const Outcome a = run_clip(scene, options, Device::kCuda, spinning, 40);
  const Outcome b = run_clip(scene, options, Device::kCuda, spinning, 40);
  EXPECT_GE(a.converged, 39);
  EXPECT_EQ(a.state.x, b.state.x);
  EXPECT_EQ(a.residual, b.residual);
}

TEST_F(OnCard, AutoTakesNewtonOfStiffScenesThere) {
  Scene scene = beam_of_regions(TimeScheme::kEuler);
  scene.materials[0].poisson = 0.49;
  finish_scene(scene);
  Solver solver(scene, {.device = Device::kAuto});
  EXPECT_EQ(solver.mode(), SolverMode::kNewton);
  EXPECT_NE(solver.device(), "cpu");
  State state = initial_state(scene);
  EXPECT_TRUE(solver.step(state).converged);
}

/// Few iterations are left to quasi, so that newton ends each step.
TEST_F(OnCard, NewtonTakesOverASingleStep) {
  const Scene scene = beam_of_regions(TimeScheme::kBdf2);
  SolverOptions options{.tolerance = 1e-9, .max_outer = 16};
  const Outcome a = run_clip(scene, options, Device::kCpu, {}, 1);
  const Outcome b = run_clip(scene, options, Device::kCuda, {}, 1);
  EXPECT_GT(a.report.outer, 16);  // those of quasi, and steps of newton
  EXPECT_GT(b.report.outer, 16);
  EXPECT_EQ(b.report.converged, a.report.converged);
  EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-6);
}

/// A start that tears a body apart, and no iteration of quasi: newton begins at the state before.
TEST_F(OnCard, StepsThatCannotEndAtTheirStartRetreat) {
  const Scene scene = falling_bar(TimeScheme::kBdf2);
  State state = in_motion(scene);
  const std::vector<double> shake = random_field(scene, 0.5 * scene.grid.h, 3);
  for (size_t k = 0; k < shake.size(); ++k) state.x_before.data()[k] += shake[k];
  IncrementalPotential potential(scene);
  potential.begin_step(state, step_scheme(scene, state));
  const Zeroed<double>& now = potential.now();
  const SolverOptions options{.mode = SolverMode::kQuasi, .device = Device::kCuda, .max_outer = 0};
  const StepReport report = Solver(scene, options).step(state);
  EXPECT_EQ(report.outer, 1);  // of newton
  std::vector<double> gradient(now.size());
  const double before = potential.evaluate<double>(now.data(), gradient.data()).total();
  const PotentialValue end = potential.residual(displacement(scene, state).data(), gradient.data());
  EXPECT_LT(end.total(), before);
  EXPECT_NEAR(report.residual * reference_force(scene), norm(gradient), 1e-9 * norm(gradient));
}

}  // namespace
}  // namespace elastogen::test

#endif
