// SPDX-License-Identifier: Apache-2.0
// A clamped beam bends under its weight until its lower surface folds at the clamp: there the
// potential has saddles, along which a projected Hessian creeps.
#include "core/time_scheme.hpp"
#include "network/solver.hpp"
#include "network/step/newton_solver.hpp"
#include "tests/network/device_support.hpp"

namespace elastogen::test {
namespace {

/// 2048 voxels with steps of 1/30 s; it folds in the 18th.
Scene folding_beam() {
  Scene scene = clamped_beam(32, 8, 8, 0.25 / 8, solid(7e4, 0.4));
  scene.dt = 1.0 / 30;
  finish_scene(scene);
  return scene;
}

constexpr int kBefore = 17;

/// The state that it folds from.
State before_the_fold(const Scene& scene) {
  Solver solver(scene, {});
  State state = initial_state(scene);
  for (int k = 0; k < kBefore; ++k) {
    EXPECT_TRUE(solver.step(state).converged);
  }
  return state;
}

constexpr double kUnit = 2;

/// A step of length 3 in units of kUnit, in a model that foretells -1/2 for a slope of -1.
bool take(NewtonRegion& region, double share, double difference, bool at_edge = false) {
  PcgScalars end = region.scalars(kUnit);
  end.xx = 9, end.model = -0.5 / (kUnit * kUnit), end.at_edge = at_edge;
  return region.take_step(end, kUnit, {-1, 1e-9, difference, share, share < 1});
}

TEST(NewtonRegion, FollowsWhatStepsBring) {
  NewtonRegion region;
  EXPECT_EQ(region.scalars(kUnit).radius, 0);  // that of the first direction decides
  const struct {
    double share, difference;
    bool at_edge;
    double radius;
  } rows[] = {{1, -0.5, true, 6},        {1, -0.3, true, 6},
              {1, -0.5, false, 6},       {1, -0.1, false, 1.5},
              {0.25, -0.1, false, 0.75}, {1.0 / 512, -1e-3, false, 3.0 / 16}};
  for (const auto& row : rows) {
    EXPECT_TRUE(take(region, row.share, row.difference, row.at_edge));
    EXPECT_DOUBLE_EQ(region.scalars(kUnit).radius, row.radius) << row.share << row.difference;
  }
}

TEST(NewtonRegion, ShrinksWherePhiDoesNotFallAndGivesUpInTheEnd) {
  NewtonRegion region;
  region.begin();
  for (int k = 0; k < 4; ++k) {
    EXPECT_TRUE(take(region, 0, 0));
    EXPECT_DOUBLE_EQ(region.scalars(kUnit).radius, 3.0 / 64);
  }
  EXPECT_FALSE(take(region, 0, 0));
  // a step whose predicted gain is below the noise of Phi is not tried again
  NewtonRegion other;
  other.begin();
  EXPECT_FALSE(other.take_step({}, kUnit, {.slope = -1e-10, .noise = 1e-9}));
}

TEST(NewtonRegion, SaysWhetherStepsWereCut) {
  NewtonRegion region;
  take(region, 1, -0.5);
  EXPECT_FALSE(region.bounded());
  take(region, 1, -0.5, true);
  EXPECT_TRUE(region.bounded());
  region.begin();
  EXPECT_FALSE(region.bounded());
  EXPECT_EQ(region.scalars(kUnit).radius, 0);
}

StepReport step_by_newton(const Scene& scene, State state, int steps,
                          Device device = Device::kCpu) {
  Solver solver(scene, {.mode = SolverMode::kNewton, .device = device, .max_outer = steps});
  return solver.step(state);
}

void expect_through(const StepReport& report) {
  printf("%d Newton steps, %d PCG iterations, residual %.2g\n", report.outer, report.inner,
         report.residual);
  EXPECT_TRUE(report.converged);
  EXPECT_LE(report.outer, 60);  // 100 steps of the projected Hessian end at 7e-3
  EXPECT_LE(report.inner, 450);
  EXPECT_LT(report.min_corner_j, 0);
}

TEST(Fold, NewtonGetsThroughWhereAProjectedHessianCreeps) {
  const Scene scene = folding_beam();
  expect_through(step_by_newton(scene, before_the_fold(scene), 100));
}

TEST(Fold, ThePotentialFallsWithEveryStepOfNewton) {
  const Scene scene = folding_beam();
  const State start = before_the_fold(scene);
  const StepScheme scheme = step_scheme(scene, start);
  // one potential for the solver, another to judge it
  IncrementalPotential potential(scene), judge(scene);
  potential.begin_step(start, scheme);
  judge.begin_step(start, scheme);
  Preconditioner<float> first(potential, {});
  Zeroed<double> u = potential.now();
  std::vector<double> g(u.size());
  potential.set_nodal_rotations(u.data());
  const auto phi = [&] { return judge.evaluate<double>(u.data(), g.data()); };
  PotentialValue before = phi();
  int falls = 0;
  const auto watch = [&] {  // polled at least once a step
    const PotentialValue now = phi();
    EXPECT_LE(now.total(), before.total() + judge.noise(before, 2.3e-16));
    falls += now.total() < before.total();
    before = now;
    return false;
  };
  // each of Newton's steps is watched
  NewtonSolver solver(potential);
  const IterationResult result =
      solver.solve(u.data(), 0.95e-3 * reference_force(scene), 100, 400, first, watch);
  EXPECT_TRUE(result.converged);
  EXPECT_TRUE(result.bounded);
  EXPECT_GE(falls, result.outer - 1);
}

#ifdef ELASTOGEN_CUDA

class FoldOnCard : public OnCard {};

TEST_F(FoldOnCard, NewtonGetsThrough) {
  const Scene scene = folding_beam();
  const State start = before_the_fold(scene);
  const StepReport host = step_by_newton(scene, start, 100),
                   card = step_by_newton(scene, start, 100, Device::kCuda);
  expect_through(card);
  // the same minimum: rounding decides when folds snap, not how
  EXPECT_NEAR(card.energy.elastic / host.energy.elastic, 1, 1e-4);
  EXPECT_NEAR(card.energy.gravity / host.energy.gravity, 1, 1e-4);
}

#endif

}  // namespace
}  // namespace elastogen::test
