// SPDX-License-Identifier: Apache-2.0
// How the weights of nets that have no file are made, and where they are kept.

#pragma once

#include "core/tensor_file.hpp"
#include "scene/nets.hpp"
#include "training/fit_report.hpp"

#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// Whether a model card is of the present formula, and of the material's law and Poisson ratio.
bool is_of(const TensorFile& weights, const FitMaterial& material);

/// A weight file that was made now.
struct MadeWeights {
  std::string bytes;
  FitReport report;  ///< on strains that the fit has not seen
  int iterations = 0;
  double seconds = 0;  ///< of the fit and its report
};

/// The weight file of a law or sum of laws: the last layer is fitted by Levenberg-Marquardt on the
/// shipped hidden layers, and measured. It may miss its limits; the report says so.
/// @throws Error (usage) where no folder has hidden layers.
MadeWeights made_weights(const FitMaterial& material);

struct WeightFile {
  std::string bytes;
  std::string place;              ///< its path; of one that was made now its name
  std::optional<FitReport> made;  ///< of one that was made now
};

/// The weights of a law or sum of laws: those of the first folder that has them, else those of the
/// user's cache under the hash of the hidden layers, else made now in about a second and, if they
/// pass, kept there; a cache that cannot be written or read is done without.
/// @throws Error as made_weights; (asset) for a file that cannot be read.
WeightFile weights_of(const FitMaterial& material);

/// The net of a material, of weights_of: what runs of the command ask for nets without a file.
/// @throws Error as weights_of; (usage) naming the material whose fit misses its limits; (asset)
/// for
///         a file that read_weights refuses.
std::shared_ptr<const LearnedLaw> make_net(const Material& material, Evaluation evaluation);

}  // namespace elastogen
