// SPDX-License-Identifier: Apache-2.0
// Fits of nets that start from the shipped generator of weights.

#pragma once

#include "training/fit_report.hpp"
#include "training/last_layer_fit.hpp"

namespace elastogen {

/// Name of the file with the generator (diffusion/generate_weights.hpp).
inline constexpr const char* kGenerator = "generator.tensors";

/// A fit and its measured errors.
struct JudgedFit {
  LastLayerFit fit;
  FitReport report;
};

/// Fits a material, starting from the last layer that the generator regresses. It starts from 0 if
/// no folder of weights has a generator for these hidden layers, or if the first fit misses its
/// limits.
/// @param hidden  weights from which `layer` was made, (17153).
/// @throws Error (asset) naming the file of a generator that cannot be read.
JudgedFit fit_with_start(const LastLayer& layer, std::span<const float> hidden,
                         const FitMaterial& material);

}  // namespace elastogen
