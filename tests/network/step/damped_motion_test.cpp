// SPDX-License-Identifier: Apache-2.0
// Damping by a loss factor, seen in motion: free vibrations decay by it, spin and flight do not.
#include "tests/network/step/motion_scenes.hpp"

#include <algorithm>

namespace elastogen::test {
namespace {

/// A displacement of the bar of vibrating_bar in its mode, times mass.
double mode_of_bar(const Scene& scene, const State& state) {
  double sum = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    sum += scene.mass(n) * std::cos(std::numbers::pi * scene.grid.rest(n, 0) / 0.8) *
           (state.x(n, 0) - scene.grid.rest(n, 0));
  return sum;
}

/// Logarithmic decay a unit of time of the mode in a run [1/s], from its squares summed over two
/// spans of a whole number of periods (in frames each).
double decay_rate(const Scene& scene, const std::vector<MotionFrame>& run, int span) {
  const auto size = [&](int first) {
    double sum = 0;
    for (int k = first; k < first + span; ++k)
      sum += std::pow(mode_of_bar(scene, run[size_t(k)].state), 2);
    return std::sqrt(sum);
  };
  const int last = int(run.size()) - span;
  return std::log(size(0) / size(last)) / (last * kFrame);
}

TEST(DampedMotion, VibrationsDecayByTheLossFactor) {
  // eta at the frequency of the bar, a third and three times of it: the loss factor there is in
  // proportion, and the mode decays by exp(-eta omega t / 2)
  const double eta = 0.1, period = 16 * kFrame, omega = 2 * std::numbers::pi / period;
  for (const double ratio : {1.0, 3.0, 1.0 / 3}) {
    MovingScene m = vibrating_bar(16, 0.01);
    m.scene.materials[0].loss_factor = eta;
    m.scene.materials[0].loss_frequency = 1 / period / ratio;
    const std::vector<MotionFrame> fine = play(m, TimeScheme::kSdirk2, 64, 8),
                                   run = play(m, TimeScheme::kAuto, 64);
    m.scene.materials[0].loss_factor = 0;
    const std::vector<MotionFrame> free = play(m, TimeScheme::kSdirk2, 64, 8);
    const double expected = eta * ratio * omega / 2;
    const double scheme = decay_rate(m.scene, free, 16), rate = decay_rate(m.scene, fine, 16);
    printf("ratio %.2f: decays by %.4f/s (auto %.4f), expected %.4f, without damping %.5f\n", ratio,
           rate, decay_rate(m.scene, run, 16), expected, scheme);
    EXPECT_NEAR(rate, expected, 0.05 * expected);
  }
}

TEST(DampedMotion, WhatDampingTakesIsTheEnergyThatIsLost) {
  MovingScene m = vibrating_bar(16, 0.01);
  m.scene.materials[0].loss_factor = 0.3;
  m.scene.materials[0].loss_frequency = 2;
  Scene scene = m.scene;
  scene.scheme = TimeScheme::kSdirk2;
  scene.dt = kFrame / 8;
  finish_scene(scene);
  Solver solver(scene, {});
  solver.begin(m.start);
  double start = 0, damped = 0, end = 0;
  for (int64_t n = 0; n < m.start.v.rows(); ++n)
    start += scene.mass(n) / 2 * m.start.v(n, 0) * m.start.v(n, 0);
  for (int k = 0; k < 400; ++k) {
    const StepReport r = solver.advance();
    ASSERT_TRUE(r.converged);
    EXPECT_GE(r.damped, 0);
    damped += r.damped;
    end = r.energy.kinetic + r.energy.elastic + r.energy.hourglass;
  }
  EXPECT_LT(end, 0.5 * start);
  EXPECT_NEAR(start - end, damped, 2e-3 * start);
}

TEST(DampedMotion, SpinAndFlightLoseNothing) {
  MovingScene m = spinning_ball(50, 10);
  m.scene.materials[0].loss_factor = 0.3;
  m.scene.gravity = {0, -9.81, 0};
  finish_scene(m.scene);
  const std::vector<MotionFrame> run = play(m, TimeScheme::kAuto, 60);
  const Vec3 before = mean_motion(m.scene, m.start).spin,
             after = mean_motion(m.scene, run.back().state).spin;
  EXPECT_LT(safe_norm(minus(after, before)), 1e-12 * safe_norm(before));
  EXPECT_LE(solves_a_frame(run), 1.1);
  const double t = 60 * kFrame;
  EXPECT_NEAR(
      mean_motion(m.scene, run.back().state).centre[1] - mean_motion(m.scene, m.start).centre[1],
      -9.81 * t * t / 2, 1e-10);
}

}  // namespace
}  // namespace elastogen::test
