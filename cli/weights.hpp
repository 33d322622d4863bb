// SPDX-License-Identifier: Apache-2.0
// Makes the weights of nets that have no file, and keeps them in a cache.

#pragma once

#include "core/tensor_file.hpp"
#include "scene/nets.hpp"
#include "training/fit_report.hpp"

#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// Whether a model card has the present formula and the material's law and Poisson ratio.
bool is_of(const TensorFile& weights, const FitMaterial& material);

/// A weight file that was just made.
struct MadeWeights {
  std::string bytes;
  FitReport report;  ///< on strains that the fit did not use
  int iterations = 0;
  double seconds = 0;  ///< of fit and report
};

/// The weight file of a law or sum of laws: its last layer is fitted by Levenberg-Marquardt on the
/// shipped hidden layers, then measured. It may miss its limits; the report tells.
/// @throws Error (usage) if no folder has hidden layers.
MadeWeights made_weights(const FitMaterial& material);

struct WeightFile {
  std::string bytes;
  std::string place;              ///< its path, or its name if it was just made
  std::optional<FitReport> made;  ///< set if it was just made
};

/// The weights of a law or sum of laws: from the first folder that has them, else from the user's
/// cache under the hash of the hidden layers, else made in about a second and, if they keep their
/// limits, stored in the cache. A cache that cannot be read or written is ignored.
/// @throws Error as made_weights; (asset) for a file that cannot be read.
WeightFile weights_of(const FitMaterial& material);

/// The net of a material by weights_of. Runs of the command call it for nets without a file.
/// @throws Error as weights_of; (usage) naming the material whose fit misses its limits; (asset)
///         for a file that read_weights refuses.
std::shared_ptr<const LearnedLaw> make_net(const Material& material, Evaluation evaluation);

}  // namespace elastogen
