// SPDX-License-Identifier: Apache-2.0
// Steps of particles where Newton's method does not reach the tolerance.
#include "mpm_fem/integrators/implicit_mpm.hpp"
#include "scene/particle_integrator.hpp"
#include "scene/particle_setup.hpp"
#include "scene/shape.hpp"
#include "scene/stepper.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// Stiff sand that hits rough ground, a step of dt.
RunDescription falling_sand(double speed, double dt) {
  RunDescription run;
  run.shape = parse_shape("rectangle(-0.03,0,0, 0.03,0.06,0)");
  run.h = 0.01;
  run.yield = SandYield{.keeps_volume = false};
  run.material = {"sand", Law::kHencky, 1e7, 0.3, 1000};
  run.floor.emplace();
  run.friction = kSticks;
  run.motion.velocity[1] = -speed;
  run.particles.jitter = 0;
  run.particles.dt = dt;
  run.fps = 1 / dt;
  run.substeps = 1;
  return run;
}

/// Its first step.
StepReport one_step(const RunDescription& run, State* state = nullptr) {
  const auto setup = set_up(shape_asset(*run.shape), run);
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
  stepper->begin(run.motion);
  const StepReport report = stepper->advance();
  EXPECT_TRUE(report.finite);
  EXPECT_NEAR(stepper->state().time, 1 / run.fps, 1e-12);
  if (state) *state = stepper->state();
  return report;
}

/// At 5 m/s a step of 2 ms, a cell long, misses the tolerance, and both halves of it meet it.
TEST(ParticleStepper, AStepThatMissesTheToleranceIsHalvedAndCounted) {
  constexpr double kDt = 2e-3;
  const RunDescription run = falling_sand(5, kDt);
  State state;
  const StepReport report = one_step(run, &state);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.fallbacks, 1);
  EXPECT_LE(report.residual, run.solver.tolerance);
  // the same by hand
  const auto setup = set_up(shape_asset(*run.shape), run);
  mpm::MpmScene scene = mpm_scene(setup, run.particles);
  mpm::Particles p = setup.particles->particles;
  for (int64_t k = 0; k < p.count(); ++k) p.v(k, 1) = -5;
  mpm::ImplicitMpm<2> solver(scene, {.tolerance = run.solver.tolerance});
  mpm::Particles missed = p;
  scene.dt = kDt;
  const mpm::MpmStepReport whole = solver.step(0, missed);
  EXPECT_FALSE(whole.converged);
  EXPECT_TRUE(whole.finite);
  EXPECT_GT(whole.residual, run.solver.tolerance);
  scene.dt = kDt / 2;
  int solves = whole.outer;
  for (const double time : {0.0, kDt / 2}) {
    const mpm::MpmStepReport half = solver.step(time, p);
    EXPECT_TRUE(half.converged);
    solves += half.outer;
  }
  EXPECT_EQ(report.outer, solves);
  EXPECT_EQ(state.v, p.v);
}

/// A tolerance that no part can meet: parts are halved to the limit, and the step stays a draft.
TEST(ParticleStepper, AStepThatNoPartCanConvergeIsADraftWithItsResidual) {
  RunDescription run = falling_sand(1, 1e-3);
  run.solver.tolerance = 1e-16;
  const StepReport report = one_step(run);
  EXPECT_FALSE(report.converged);
  EXPECT_GT(report.residual, run.solver.tolerance);
  EXPECT_LT(report.residual, 1e-6);
  EXPECT_GE(report.fallbacks, 4);
  EXPECT_LE(report.fallbacks, 2 * 16);  // no part is shorter than a sixteenth
}

/// The published loop and explicit steps ask nothing of the residual.
TEST(ParticleStepper, OnlyWhatIsCertifiedIsHalved) {
  RunDescription run = falling_sand(1, 1e-3);
  run.particles.integrator = Integrator::kPnFixedPoint;
  run.particles.passes = 1;
  const StepReport report = one_step(run);
  EXPECT_FALSE(report.converged);
  EXPECT_GT(report.residual, run.solver.tolerance);
  EXPECT_EQ(report.fallbacks, 0);
  run.particles.integrator = Integrator::kFrozenFixedPoint;
  EXPECT_TRUE(one_step(run).converged);
  run.particles.integrator = Integrator::kExplicit;
  run.particles.substeps = 40;
  const StepReport explicit_report = one_step(run);
  EXPECT_TRUE(explicit_report.converged);
  EXPECT_EQ(explicit_report.residual, 0);
  EXPECT_EQ(explicit_report.fallbacks, 0);
}

}  // namespace
}  // namespace elastogen::test
