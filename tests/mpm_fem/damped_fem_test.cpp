// SPDX-License-Identifier: Apache-2.0
// Damping of finite elements in motion: decay, energy, agreement with the network, refusals.
#include "core/error.hpp"
#include "mpm_fem/integrators/explicit_fem.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "tests/mpm_fem/stage_scenes.hpp"

#include <numbers>

namespace elastogen::test {
namespace {

using fem::FemScene;
using fem::FemState;
using fem::FemStepReport;
using fem::Scheme;

constexpr double kPeriod = 16 * kFrame;

/// A bar of one row of voxels that vibrates along its length in its first mode, with nu = 0.
MovingScene damped_bar(double loss, double frequency) {
  const int count = 16;
  const double h = 0.05, L = count * h, c = 2 * L / kPeriod;
  MovingScene m{scene_on(make_box(count, 1, 1, h), solid(1000 * c * c, 0)), {}};
  m.scene.materials[0].loss_factor = loss;
  m.scene.materials[0].loss_frequency = frequency;
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  const double speed = 0.01 * L * 2 * std::numbers::pi / kPeriod;
  for (int64_t n = 0; n < m.start.v.rows(); ++n)
    m.start.v(n, 0) = speed * std::cos(std::numbers::pi * m.scene.grid.rest(n, 0) / L);
  return m;
}

/// Logarithmic decay of the mode a unit of time [1/s], from its squares summed over the first period
/// and the last one.
double decay_rate(const Scene& scene, const std::vector<MotionFrame>& run) {
  const Array<double>& X = scene.grid.rest;
  const auto size = [&](size_t first) {
    double sum = 0;
    for (size_t k = first; k < first + 16; ++k) {
      double mode = 0;
      for (int64_t n = 0; n < X.rows(); ++n)
        mode += scene.mass(n) * std::cos(std::numbers::pi * X(n, 0) / 0.8) *
                (run[k].state.x(n, 0) - X(n, 0));
      sum += mode * mode;
    }
    return std::sqrt(sum);
  };
  const size_t last = run.size() - 16;
  return std::log(size(0) / size(last)) / (double(last) * kFrame);
}

TEST(DampedFem, VibrationsDecayByTheLossFactor) {
  // the loss factor is in proportion to frequency: the mode decays by exp(-eta omega t / 2)
  const double eta = 0.1, omega = 2 * std::numbers::pi / kPeriod;
  for (const double ratio : {1.0, 3.0}) {
    const MovingScene m = damped_bar(eta, 1 / kPeriod / ratio);
    const double rate = decay_rate(m.scene, play(m, Scheme::kSdirk2, 64, 8)),
                 by_auto = decay_rate(m.scene, play(m, Scheme::kAuto, 64)),
                 expected = eta * ratio * omega / 2;
    printf("ratio %.2f: decays by %.4f/s (auto %.4f), expected %.4f\n", ratio, rate, by_auto,
           expected);
    EXPECT_NEAR(rate, expected, 0.05 * expected);
  }
}

TEST(DampedFem, WhatDampingTakesIsTheEnergyThatIsLost) {
  const MovingScene m = damped_bar(0.3, 2);
  FemScene scene = as_fem(m.scene);
  scene.scheme = Scheme::kSdirk2, scene.dt = kFrame / 8;
  fem::StageFem solver(scene, stage_options(1e-6));
  FemState state = as_fem(scene, m.start);
  double start = 0, damped = 0, end = 0;
  for (int64_t n = 0; n < m.start.v.rows(); ++n)
    start += m.scene.mass(n) / 2 * m.start.v(n, 0) * m.start.v(n, 0);
  for (int k = 0; k < 300; ++k) {
    const FemStepReport r = solver.step(state);
    ASSERT_TRUE(r.converged);
    EXPECT_GE(r.damped, 0);
    damped += r.damped;
    end = r.energy.kinetic + r.energy.elastic + r.energy.hourglass;
  }
  EXPECT_LT(end, 0.5 * start);
  EXPECT_NEAR(start - end, damped, 2e-3 * start);
}

TEST(DampedFem, NetworkAndFiniteElementsAgreeOverARunWithContactAndFriction) {
  // as StageMotion's, with damping: the same steps, and the same bound
  struct Case {
    const char* name;
    MovingScene m;
    int frames;
  };
  for (Case& c : std::vector<Case>{{"pendulum", small_pendulum(1.2), 20},
                                   {"ball that hops", small_ball(1e6, 1), 10},
                                   {"block that slides", small_block(std::numbers::pi / 4), 8}}) {
    c.m.scene.materials[0].loss_factor = 0.1;
    c.m.scene.materials[0].loss_frequency = 10;
    const std::vector<MotionFrame> run = play(c.m, Scheme::kAuto, c.frames, 1, 1e-8);
    const SolverOptions options{
        .mode = SolverMode::kNewton, .tolerance = 1e-8, .follows_time_error = false};
    const std::vector<MotionFrame> network = play(c.m, TimeScheme::kAuto, c.frames, 1, options);
    double off = 0;
    int steps = 0;
    ASSERT_EQ(run.size(), network.size());
    for (size_t k = 0; k < run.size(); ++k) {
      EXPECT_EQ(run[k].steps, network[k].steps) << c.name << ", frame " << k;
      off = std::max(off, rms_distance(c.m.scene, run[k].state.x, network[k].state.x));
      steps += run[k].steps;
    }
    printf("%s: %d steps, off by %.1e m\n", c.name, steps, off);
    EXPECT_LT(off, 1e-9) << c.name;
  }
}

TEST(DampedFem, NetworkAndFiniteElementsAgreeInEqualSteps) {
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2}) {
    MovingScene m = small_pendulum(1.2);
    m.scene.materials[0].loss_factor = 0.5;
    m.scene.scheme = scheme;
    finish_scene(m.scene);
    FemScene scene = as_fem(m.scene);
    scene.scheme = scheme == TimeScheme::kEuler ? Scheme::kEuler : Scheme::kBdf2;
    fem::ImplicitFem integrator(scene, {.tolerance = 1e-9, .as_positions = true});
    FemState state = as_fem(scene, m.start);
    Solver solver(m.scene, {.mode = SolverMode::kNewton, .tolerance = 1e-9});
    State network = m.start;
    for (int k = 0; k < 10; ++k) {
      const FemStepReport r = integrator.step(state);
      const StepReport s = solver.step(network);
      ASSERT_TRUE(r.converged && s.converged);
      EXPECT_GT(r.damped, 0);
      EXPECT_NEAR(r.damped, s.damped, 1e-6 * s.damped);
    }
    EXPECT_LT(rms_distance(m.scene, as_positions(scene, state).x, network.x), 1e-9);
  }
}

TEST(DampedFem, OthersRefuseIt) {
  MovingScene m = small_pendulum(1);
  m.scene.materials[0].loss_factor = 0.1;
  FemScene scene = as_fem(m.scene);
  EXPECT_NO_THROW(fem::ImplicitFem{scene});
  EXPECT_THROW(fem::solve_static(scene), Error);
  scene.scheme = Scheme::kNewmark;
  EXPECT_THROW(fem::ImplicitFem{scene}, Error);
  scene.scheme = Scheme::kEuler;
  scene.mesh = fem::voxel_mesh(m.scene, fem::Element::kHexBbar);
  EXPECT_THROW(fem::ExplicitFem{scene}, Error);
  scene.yields = {MetalYield{}};
  EXPECT_THROW(fem::ImplicitFem{scene}, Error);
}

}  // namespace
}  // namespace elastogen::test
