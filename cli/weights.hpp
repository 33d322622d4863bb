// SPDX-License-Identifier: Apache-2.0
// Where the weights of nets are found, how those that are nowhere are made, and those of a scene.

#pragma once

#include "cli/options.hpp"
#include "core/tensor_file.hpp"
#include "training/fit_report.hpp"

#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// Folders that are looked through in turn: that of the environment variable ELASTOGEN_WEIGHTS,
/// the user's cache (XDG_CACHE_HOME or ~/.cache, elastogen/weights), that beside an installed
/// program, that of the sources.
std::vector<std::string> weight_folders();

/// Whether a model card is of the present formula, and of the material's law and Poisson ratio.
bool is_of(const TensorFile& weights, const FitMaterial& material);

/// Path of a file of that name in the first folder that has one, "" if none has.
std::string find_weight_file(const std::string& name);

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

/// The net of a material, of weights_of, for Poisson ratios to 0.499, exponents of Ogden from -4 to
/// 8 and limits of Gent from 7.5 on: beyond, fits miss their limits.
/// @throws Error as weights_of; (usage) naming the material that is beyond, or whose fit misses its
///         limits; (asset) for a file that read_weights refuses.
std::shared_ptr<const LearnedLaw> net_of(const Material& material, Evaluation evaluation);

/// The nets of a scene's materials; none where the options ask for the laws. With energy auto a
/// material without a net is left to its law, null, if all are there are none.
/// @param notes  gets a sentence for each such material.
/// @throws Error as net_of, with energy neural.
LearnedLaws scene_nets(const Scene& scene, const AnimateOptions& options,
                       std::vector<std::string>& notes);

}  // namespace elastogen
