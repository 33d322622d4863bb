// SPDX-License-Identifier: Apache-2.0
// Fitted weights as files: the tensor "neural_mtl" of (17153) numbers and a model card of texts
// (docs/formats.md).

#pragma once

#include "core/tensor_file.hpp"
#include "training/fit_report.hpp"

#include <map>
#include <span>
#include <string>
#include <vector>

namespace elastogen {

/// Texts "trainer.*" of a model card, which tell how the weights were made.
using TrainerCard = std::map<std::string, std::string>;

/// Weights of a material with their model card: form, law, poisson, error.*, trainer.*.
TensorFile mtl_file(const FitMaterial& material, std::span<const float> weights,
                    const FitReport& report, const TrainerCard& trainer);

/// Hidden layers for many materials: weights with last layer 0, with form and trainer.*.
TensorFile hidden_file(std::span<const float> weights, const TrainerCard& trainer);

/// Reports as CSV: a head line, then one line for each material.
std::string report_table(const std::vector<FitMaterial>& materials,
                         const std::vector<FitReport>& reports);

/// The shortest text that reads back as this number.
std::string shortest_text(double value);

}  // namespace elastogen
