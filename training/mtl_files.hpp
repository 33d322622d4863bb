// SPDX-License-Identifier: Apache-2.0
// Fitted weights as files: the tensor "neural_mtl" of (17153) numbers and a model card of texts
// (docs/formats.md).

#pragma once

#include "core/tensor_file.hpp"
#include "training/fit_neural_mtl.hpp"
#include "training/fit_report.hpp"

namespace elastogen {

/// Weights of a material with their card: law, poisson, error.*, trainer.*.
TensorFile mtl_file(const FitMaterial& material, std::span<const float> weights,
                    const FitReport& report, const FitOptions& options);

/// Reports as CSV with a head line, one line a material.
std::string report_table(const std::vector<FitMaterial>& materials,
                         const std::vector<FitReport>& reports);

}  // namespace elastogen
