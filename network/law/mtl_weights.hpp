// SPDX-License-Identifier: Apache-2.0
// Weight files of NeuralMTL: one tensor "neural_mtl" of 17153 numbers, and the model card that says
// which law it was fitted to and how well (docs/formats.md, weights).

#pragma once

#include "core/tensor_file.hpp"
#include "network/law/learned_law.hpp"

namespace elastogen {

/// Errors of a fit over the fitted box on strains that it has not seen, relative to the local
/// stress and tangent.
struct FitErrors {
  double stress_median = 0, stress_p99 = 0, stress_max = 0, tangent_p99 = 0;
};

/// Limits of a fit: 0.1 %, 0.5 %, 2 % of the local stress, 2 % of the tangent.
inline constexpr FitErrors kFitLimits{1e-3, 5e-3, 2e-2, 2e-2};

/// Whether every error is a number within its limit.
bool within(const FitErrors& errors, const FitErrors& limits = kFitLimits);

/// Errors on `count` strains drawn from a seed: half uniform in the box, half on spheres of
/// log-uniform radius 1e-4 ... 0.9 around rest. Relative to |t| + 1e-4 (2 mu + lambda) and |H|.
FitErrors fit_errors(const LearnedLaw& learned, int count = 20000, uint64_t seed = 7);

/// Name of the file of a law at a Poisson ratio, "neo-hookean-0.45.weights".
std::string weight_file_name(Law law, double poisson);

/// The law in the bytes of a weight file.
/// @param place  name of the file, for messages.
/// @throws Error (asset) as decode_tensors, and if the card is of another law or Poisson ratio,
///         lacks an error, or has one beyond its limit.
std::shared_ptr<const LearnedLaw> read_weights(std::string_view bytes, const std::string& place,
                                               Law law, double poisson, Evaluation evaluation);

}  // namespace elastogen
