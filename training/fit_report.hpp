// SPDX-License-Identifier: Apache-2.0
// Errors of fitted weights on strains that no fit has used, in the declared box, in double.

#pragma once

#include "core/array.hpp"
#include "training/fit_material.hpp"

#include <span>
#include <vector>

namespace elastogen {

/// Relative errors with M = 2 mu + lambda. The moduli at rest are exact for any weights.
struct FitReport {
  double stress_median = 0;  ///< |t_theta - t| / (|t| + 1e-4 M)
  double stress_p99 = 0, stress_max = 0;
  double tangent_p99 = 0;  ///< |H_theta - H|_F / |H|_F
  double energy_max = 0;   ///< |psi_theta - psi| / (psi + 1e-6 M)
  int64_t strains = 0;

  /// Whether the net may replace the law: stress within 0.1 % (median), 0.5 % (99 of 100 strains)
  /// and 2 % (all), tangent within 2 % (99 of 100).
  bool passes() const {
    return stress_median <= 1e-3 && stress_p99 <= 5e-3 && stress_max <= 2e-2 && tangent_p99 <= 2e-2;
  }
};

struct ReportOptions {
  int64_t strains = 20000;
  uint64_t seed = 0x6865'6c64'6f75'7421;  ///< a seed that no fit uses
};

/// The errors of FitReport at each strain, in the order of the strains. Not-a-number counts as
/// infinite.
struct StrainErrors {
  std::vector<double> stress, tangent, energy;
};

/// Errors of the weights of a material, (17153), at log stretches e, (n, 3).
/// @throws Error (asset) for another number of weights, or weights that are not finite.
StrainErrors strain_errors(const FitMaterial& material, std::span<const float> weights,
                           const Array<double>& e);

/// The report from errors at one strain or more: medians, percentiles and maxima.
FitReport report_of(StrainErrors errors);

/// Report for the weights of a material, (17153). Not-a-number counts as infinite.
/// @throws Error (asset) for another number of weights.
FitReport fit_report(const FitMaterial& material, std::span<const float> weights,
                     const ReportOptions& options = {});

}  // namespace elastogen
