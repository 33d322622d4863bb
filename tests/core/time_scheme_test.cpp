// SPDX-License-Identifier: Apache-2.0
#include "core/time_scheme.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace elastogen {
namespace {

using Complex = std::complex<double>;

/// One vibrating point x'' = -omega^2 x, stepped as the solvers step a node.
struct Oscillator {
  double omega = 0, x = 0, v = 0, x_before = 0, v_before = 0;

  /// The state that stands for x + i v / omega.
  Complex phase() const { return {x, v / omega}; }

  void step(const StepScheme& s) {
    const double target = x + predicted_motion(s, x, v, x_before, v_before, 0);
    // stationary point of a0/(2 dt^2) (x - target)^2 + omega^2/2 x^2
    const double next = s.a0 * target / (s.a0 + std::pow(omega * s.dt, 2));
    const double speed = velocity_after(s, next, x, x_before);
    x_before = x, v_before = v;
    x = next, v = speed;
  }
};

TEST(TimeScheme, EulerHasTheAmplitudeAndFrequencyOfItsClosedForm) {
  for (const double omega_dt : {0.01, 0.1, 0.5, 1.0}) {
    const StepScheme euler{TimeScheme::kEuler, 0.01, 1};
    Oscillator point{omega_dt / euler.dt, 1, 0, 0, 0};
    const double frequency = std::atan(omega_dt);
    for (int n = 1; n <= 200; ++n) {
      const Complex before = point.phase();
      point.step(euler);
      const double amplitude = std::pow(1 + omega_dt * omega_dt, -n / 2.0);
      ASSERT_NEAR(std::abs(point.phase()) / amplitude, 1, 1e-8);
      ASSERT_NEAR(-std::arg(point.phase() / before), frequency, 1e-8);
    }
  }
}

TEST(TimeScheme, Bdf2HasTheAmplitudeAndFrequencyOfItsClosedForm) {
  for (const double omega_dt : {0.01, 0.1, 0.5, 1.0}) {
    const StepScheme bdf2{TimeScheme::kBdf2, 0.01, 2.25};
    const Complex root = (2.0 + std::sqrt(Complex(1, 2 * omega_dt))) / Complex(3, -2 * omega_dt);
    // x + i v/omega turns in the opposite sense to the root
    const double omega = omega_dt / bdf2.dt, real = std::real(root), imaginary = -std::imag(root);
    Oscillator point{omega, real, imaginary * omega, 1, 0};
    for (int n = 2; n <= 200; ++n) {
      const Complex before = point.phase();
      point.step(bdf2);
      ASSERT_NEAR(std::abs(point.phase()) / std::pow(std::abs(root), n), 1, 1e-8);
      ASSERT_NEAR(-std::arg(point.phase() / before), std::arg(root), 1e-8);
    }
  }
}

TEST(TimeScheme, AmplitudeKeptIsThatOfTheTable) {
  const double omega_dt[7] = {0.01, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0};
  const double euler[7] = {0.969, 0.855, 0.731, 0.536, 0.395, 0.220, 0.063};
  const double bdf2[7] = {1.0, 0.9998, 0.9985, 0.9885, 0.965, 0.878, 0.591};
  for (int k = 0; k < 7; ++k) {
    EXPECT_NEAR(amplitude_kept(TimeScheme::kEuler, omega_dt[k]), euler[k], 6e-4);
    EXPECT_NEAR(amplitude_kept(TimeScheme::kBdf2, omega_dt[k]), bdf2[k], 6e-4);
  }
}

TEST(TimeScheme, AmplitudeKeptIsWhatARunKeepsOverOnePeriod) {
  const StepScheme euler{TimeScheme::kEuler, 0.1, 1};
  Oscillator point{0.2 / euler.dt, 1, 0, 0, 0};
  for (int n = 0; n < 100; ++n) point.step(euler);
  const double periods = 100 * std::atan(0.2) / (2 * std::numbers::pi);
  EXPECT_NEAR(std::pow(std::abs(point.phase()), 1 / periods),
              amplitude_kept(TimeScheme::kEuler, 0.2), 1e-12);
}

TEST(TimeScheme, EulerFallsByHalfGTimesTimePlusStep) {
  const StepScheme euler{TimeScheme::kEuler, 0.02, 1};
  double x = 0, v = 0;
  for (int n = 1; n <= 100; ++n) {
    const double next = x + predicted_motion(euler, x, v, 0, 0, -9.81);
    v = velocity_after(euler, next, x, 0);
    x = next;
    const double t = n * euler.dt;
    ASSERT_NEAR(x, -9.81 / 2 * t * (t + euler.dt), 1e-12 * (1 + t * t * 10));
    ASSERT_NEAR(v, -9.81 * t, 1e-11);
  }
}

TEST(TimeScheme, Bdf2FollowsAParabolaExactly) {
  const StepScheme bdf2{TimeScheme::kBdf2, 0.02, 2.25};
  const auto place = [](double t) { return 3 + 2 * t - 9.81 / 2 * t * t; };
  double x = place(0.02), v = 2 - 9.81 * 0.02, x_before = 3, v_before = 2;
  for (int n = 2; n <= 100; ++n) {
    const double next = x + predicted_motion(bdf2, x, v, x_before, v_before, -9.81);
    const double speed = velocity_after(bdf2, next, x, x_before);
    x_before = x, v_before = v, x = next, v = speed;
    ASSERT_NEAR(x, place(n * bdf2.dt), 1e-11);
    ASSERT_NEAR(v, 2 - 9.81 * n * bdf2.dt, 1e-10);
  }
}

TEST(TimeScheme, SecondExtrapolationFollowsAParabolaExactly) {
  const double dt = 0.02;
  const auto place = [](double t) { return 3 + 2 * t - 9.81 / 2 * t * t; };
  const double way = place(3 * dt) - place(2 * dt);
  const StepScheme euler{TimeScheme::kEuler, dt, 1}, bdf2{TimeScheme::kBdf2, dt, 2.25};
  const double mean = (place(2 * dt) - place(dt)) / dt, mean_before = (place(dt) - place(0)) / dt;
  EXPECT_NEAR(extrapolated_motion(euler, 2, mean, mean_before), way, 1e-14);
  const double v = 2 - 9.81 * 2 * dt, v_before = 2 - 9.81 * dt;
  EXPECT_NEAR(extrapolated_motion(bdf2, 2, v, v_before), way, 1e-14);
  // the first order misses the effect of a force during a step
  EXPECT_NEAR(extrapolated_motion(bdf2, 1, v, v_before), way + 9.81 / 2 * dt * dt, 1e-14);
}

TEST(TimeScheme, Bdf2NeedsAStepBefore) {
  Scene scene;
  scene.dt = 0.01, scene.scheme = TimeScheme::kBdf2;
  State state;
  EXPECT_EQ(step_scheme(scene, state).scheme, TimeScheme::kEuler);
  EXPECT_EQ(step_scheme(scene, state).a0, 1);
  state.x_before = Array<double>(1, 3);
  EXPECT_EQ(step_scheme(scene, state).scheme, TimeScheme::kBdf2);
  EXPECT_EQ(step_scheme(scene, state).a0, 2.25);
  EXPECT_EQ(step_scheme(scene, state).dt, 0.01);
  scene.scheme = TimeScheme::kEuler;
  EXPECT_EQ(step_scheme(scene, state).scheme, TimeScheme::kEuler);
}

}  // namespace
}  // namespace elastogen
