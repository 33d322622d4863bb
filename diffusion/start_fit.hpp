// SPDX-License-Identifier: Apache-2.0
// Quality of a net after some iterations from a start, by which generators of weights are judged.

#pragma once

#include "training/fit_report.hpp"
#include "training/last_layer_fit.hpp"

namespace elastogen {

/// A net after some iterations; after fewer if the fit ended before.
struct StartFit {
  int iterations = 0;        ///< number that was asked for
  std::vector<float> layer;  ///< last layer, (128)
  FitReport report;
  double fit_seconds = 0;     ///< of the fit up to this iteration, in one run
  double report_seconds = 0;  ///< of this report
};

/// Fits a material from a start and reports after 0 and other numbers of iterations.
/// @param layer       its options limit the iterations.
/// @param start       (128).
/// @param iterations  ascending, the first 0.
/// @throws Error (usage) for a start of another size and iterations that do not ascend from 0.
std::vector<StartFit> fit_from(const LastLayer& layer, std::span<const float> hidden,
                               const FitMaterial& material, std::span<const float> start,
                               std::span<const int> iterations, const ReportOptions& judged);

}  // namespace elastogen
