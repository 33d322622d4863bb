// SPDX-License-Identifier: Apache-2.0
// What steps of particles do where Newton's method does not come to the tolerance.
#include "core/reduce.hpp"
#include "mpm_fem/integrators/implicit_mpm.hpp"
#include "scene/particle_integrator.hpp"
#include "scene/shape.hpp"
#include "scene/stepper.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen::test {
namespace {

/// Stiff sand that hits the ground.
RunDescription falling_sand(double dt) {
  RunDescription run;
  run.shape = parse_shape("rectangle(-0.05,0,0, 0.05,0.1,0)");
  run.h = 0.01;
  run.yield = SandYield{.keeps_volume = false};
  run.material = {"sand", Law::kHencky, 1e7, 0.3, 1000};
  run.floor.emplace();
  run.friction = kSticks;
  run.motion.velocity = {0, -2, 0};
  run.particles.jitter = 0;
  run.particles.dt = dt;
  run.fps = 1 / dt;
  run.substeps = 1;
  return run;
}

struct Stepped {
  StepReport report;
  State state;
};

Stepped one_step(const RunDescription& run) {
  const auto setup = set_up(shape_asset(*run.shape), run);
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
  stepper->begin(run.motion);
  Stepped result;
  result.report = stepper->advance();
  result.state = stepper->state();
  return result;
}
