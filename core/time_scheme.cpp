// SPDX-License-Identifier: Apache-2.0
#include "core/time_scheme.hpp"

#include <cmath>
#include <complex>
#include <numbers>

namespace elastogen {

StepScheme step_scheme(const Scene& scene, const State& state) {
  const bool bdf2 = scene.scheme == TimeScheme::kBdf2 && !state.x_before.empty();
  if (bdf2) return {TimeScheme::kBdf2, scene.dt, 2.25};
  return {TimeScheme::kEuler, scene.dt, 1};
}

double predicted_motion(const StepScheme& s, double x, double v, double x_before, double v_before,
                        double gravity) {
  if (s.scheme == TimeScheme::kEuler) return s.dt * (v + s.dt * gravity);
  return (x - x_before) / 3 + 2 * s.dt / 9 * (4 * v - v_before) + 4 * s.dt * s.dt / 9 * gravity;
}

double velocity_after(const StepScheme& s, double x, double x_now, double x_before) {
  if (s.scheme == TimeScheme::kEuler) return (x - x_now) / s.dt;
  return (3 * (x - x_now) - (x_now - x_before)) / (2 * s.dt);
}

double free_velocity(const StepScheme& s, double v, double v_before, double gravity) {
  if (s.scheme == TimeScheme::kEuler) return v + s.dt * gravity;
  return (4 * v - v_before) / 3 + 2 * s.dt / 3 * gravity;
}

double amplitude_kept(TimeScheme scheme, double omega_dt) {
  const double turn = 2 * std::numbers::pi;
  if (scheme == TimeScheme::kEuler)
    return std::pow(1 + omega_dt * omega_dt, -turn / 2 / std::atan(omega_dt));
  const std::complex<double> i(0, 1);
  const std::complex<double> z =
      (2.0 + std::sqrt(1.0 + 2.0 * i * omega_dt)) / (3.0 - 2.0 * i * omega_dt);
  return std::pow(std::abs(z), turn / std::arg(z));
}

}  // namespace elastogen
