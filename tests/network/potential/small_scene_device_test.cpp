// SPDX-License-Identifier: Apache-2.0
// Whole steps of very small scenes on the device, against the CPU: together they run every kernel
// of a step, few times each, so that the tools of compute-sanitizer end on them within minutes.
// Nothing is here in builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "network/solver.hpp"
#include "tests/network/contact/contact_scenes.hpp"
#include "tests/network/device_support.hpp"
#include "tests/network/potential/device_potential_support.hpp"

namespace elastogen::test {
namespace {

using SmallSceneOnCard = OnCard;

constexpr double kSmallEdge = 0.025;  // of voxels [m]

/// At Courant number 6, at which the encoder takes part.
Material small_material(Law law = Law::kNeoHookean) {
  return solid(young_of_courant(6, kSmallEdge, 1.0 / 60), 0.4, law);
}

/// 96 voxels over two bricks, clamped.
Scene small_beam(Law law = Law::kNeoHookean) {
  return clamped_beam(12, 4, 2, kSmallEdge, small_material(law));
}

/// 136 voxels one after another, over more bricks than a cluster of blocks holds (MultigridOnCard).
Scene small_strip() {
  const Material soft = solid(young_of_courant(2.5, kSmallEdge, 1.0 / 60), 0.4);
  return clamped_beam(136, 1, 1, kSmallEdge, soft);
}

/// A ball of border voxels about the origin, free or held below.
Scene small_ball(TimeScheme scheme, bool held) {
  Scene scene = scene_on(ball_grid(2.7 * kSmallEdge, kSmallEdge), small_material());
  if (held) pin_below(scene, 1, -2 * kSmallEdge);
  scene.gravity = {0, -9.81, 0};
  scene.scheme = scheme;
  finish_scene(scene);
  return scene;
}

/// A block on a floor with friction that rises by more than its layer in a step.
Scene small_lift() {
  Collider floor = half_space({0, 1, 0}, -0.1 * kSmallEdge, 0.5);
  floor.path = {{0, {}}, {1.0 / 60, {0, 0.5 * kSmallEdge, 0}}};
  return box_scene(5, 4, 4, kSmallEdge, {0, 0, 0}, small_material(), {floor});
}

const StartMotion kSmallPush{.velocity = {0.2, -0.4, 0.1}, .spin = {0, 0, 1}};

struct SmallRun {
  State state;
  std::vector<StepReport> reports;
};

SmallRun run_small(const Scene& scene, SolverOptions options, Device device, int steps) {
  options.device = device;
  Solver solver(scene, options);
  EXPECT_EQ(solver.device() == "cpu", device == Device::kCpu);
  SmallRun run;
  solver.begin(initial_state(scene, kSmallPush));
  for (int k = 0; k < steps; ++k) run.reports.push_back(solver.advance());
  solver.read(run.state);
  return run;
}

/// Steps on host and device: states that agree to a tenth of the tolerance, and equal reports.
SmallRun expect_steps_of_host(const Scene& scene, const SolverOptions& options, int steps = 2) {
  const SmallRun a = run_small(scene, options, Device::kCpu, steps);
  const SmallRun b = run_small(scene, options, Device::kCuda, steps);
  const double apart = options.tolerance / 10;
  EXPECT_LE(scene.grid.voxel_count(), 200);
  EXPECT_LT(distance_of_ways(scene, b.state, a.state), apart);
  for (size_t k = 0; k < a.reports.size(); ++k) {
    const StepReport &on_host = a.reports[k], &on_card = b.reports[k];
    EXPECT_TRUE(on_card.finite);
    EXPECT_EQ(on_card.converged, on_host.converged);
    EXPECT_NEAR(on_card.inner, on_host.inner, 2 + on_host.inner / 10);
    EXPECT_NEAR(on_card.min_j, on_host.min_j, 10 * apart);
    EXPECT_EQ(on_card.outside_fit, on_host.outside_fit);
  }
  return b;
}

TEST_F(SmallSceneOnCard, TwoBricksByQuasi) {
  const Scene scene = small_beam();
  EXPECT_EQ(make_brick_rows(scene.grid, scene.material).brick_count(), 2);
  expect_steps_of_host(scene, {.mode = SolverMode::kQuasi, .tolerance = 1e-2});
}

TEST_F(SmallSceneOnCard, BorderVoxelsByQuasiInDouble) {
  const Scene scene = small_ball(TimeScheme::kBdf2, true);
  const SmallRun run =
      expect_steps_of_host(scene, {.mode = SolverMode::kQuasi, .tolerance = 1e-2, .skip = false});
  EXPECT_TRUE(run.reports.back().float64);
}

TEST_F(SmallSceneOnCard, ANetByItsTable) {
  SolverOptions options{.mode = SolverMode::kQuasi, .tolerance = 1e-2};
  options.learned = {shipped_net(Law::kNeoHookean, 0.4, Evaluation::kTable)};
  expect_steps_of_host(small_strip(), options);
}

TEST_F(SmallSceneOnCard, ANetItselfByNewton) {
  SolverOptions options{.mode = SolverMode::kNewton, .tolerance = 1e-2};
  options.learned = {shipped_net(Law::kFixedCorotated, 0.4, Evaluation::kNet)};
  expect_steps_of_host(small_beam(Law::kFixedCorotated), options);
}

TEST_F(SmallSceneOnCard, FreeFlight) {
  const Scene scene = small_ball(TimeScheme::kEuler, false);
  const SmallRun run = expect_steps_of_host(scene, {.mode = SolverMode::kQuasi, .tolerance = 1e-3});
  const State start = initial_state(scene, kSmallPush);
  double mass = 0, gained = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    mass += scene.mass(n);
    gained += scene.mass(n) * (run.state.v(n, 1) - start.v(n, 1));
  }
  EXPECT_NEAR(gained, -2 * 9.81 * scene.dt * mass, 1e-11 * mass);
}

TEST_F(SmallSceneOnCard, ContactByQuasi) {
  const SmallRun run =
      expect_steps_of_host(small_lift(), {.mode = SolverMode::kQuasi, .tolerance = 1e-2}, 1);
  EXPECT_GT(run.reports.back().energy.contact, 0);
}

TEST_F(SmallSceneOnCard, ContactByNewton) {
  const SmallRun run =
      expect_steps_of_host(small_lift(), {.mode = SolverMode::kNewton, .tolerance = 1e-2}, 1);
  EXPECT_GT(run.reports.back().energy.contact, 0);
}

TEST_F(SmallSceneOnCard, PaperLoops) {
  Scene scene = small_beam();
  scene.hourglass = Hourglass::kVariance;
  finish_scene(scene);
  expect_steps_of_host(scene, {.mode = SolverMode::kPaper, .tolerance = 1e-4, .paper = {2, 4, 9}});
}

}  // namespace
}  // namespace elastogen::test

#endif
