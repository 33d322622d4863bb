// SPDX-License-Identifier: Apache-2.0
#include "core/time_scheme.hpp"

#include <cmath>
#include <complex>
#include <numbers>

namespace elastogen {

const char* scheme_name(TimeScheme scheme) {
  constexpr const char* kNames[] = {"euler", "bdf2", "sdirk2", "auto"};
  return kNames[int(scheme)];
}

StepScheme step_scheme(const Scene& scene, bool has_before) {
  if (scene.scheme == TimeScheme::kBdf2 && has_before) return {TimeScheme::kBdf2, scene.dt, 2.25};
  return {TimeScheme::kEuler, scene.dt, 1};
}

double amplitude_kept(TimeScheme scheme, double omega_dt) {
  const double turn = 2 * std::numbers::pi;
  if (scheme == TimeScheme::kEuler)
    return std::pow(1 + omega_dt * omega_dt, -turn / 2 / std::atan(omega_dt));
  const std::complex<double> i(0, 1);
  std::complex<double> z = (2.0 + std::sqrt(1.0 + 2.0 * i * omega_dt)) / (3.0 - 2.0 * i * omega_dt);
  if (scheme == TimeScheme::kSdirk2)
    z = (1.0 + (1 - 2 * kSdirkStage) * i * omega_dt) /
        std::pow(1.0 - kSdirkStage * i * omega_dt, 2);
  return std::pow(std::abs(z), turn / std::arg(z));
}

}  // namespace elastogen
