// SPDX-License-Identifier: Apache-2.0
// How good a net is after some iterations from a start: what generators of weights are judged by.

#pragma once

#include "training/fit_report.hpp"
#include "training/last_layer_fit.hpp"

namespace elastogen {

/// A net after some iterations; fewer where the fit ended before.
struct StartFit {
  int iterations = 0;        ///< asked for
  std::vector<float> layer;  ///< the last one, (128)
  FitReport report;
  double fit_seconds = 0;     ///< of the fit up to here, in one run
  double report_seconds = 0;  ///< of this report
};

/// Fits a material from a start and reports after 0 and other numbers of iterations.
/// @param layer       its options give the most iterations.
/// @param start       (128).
/// @param iterations  ascending, the first 0.
/// @throws Error (usage) for a start of another size and iterations that do not ascend from 0.
std::vector<StartFit> fit_from(const LastLayer& layer, std::span<const float> hidden,
                               const FitMaterial& material, std::span<const float> start,
                               std::span<const int> iterations, const ReportOptions& judged);

}  // namespace elastogen
