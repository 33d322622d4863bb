// SPDX-License-Identifier: Apache-2.0
#include "core/time_scheme.hpp"

#include <cmath>
#include <complex>
#include <numbers>

namespace elastogen {

StepScheme step_scheme(const Scene& scene, bool has_before) {
  if (scene.scheme == TimeScheme::kBdf2 && has_before) return {TimeScheme::kBdf2, scene.dt, 2.25};
  return {TimeScheme::kEuler, scene.dt, 1};
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
