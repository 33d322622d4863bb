// SPDX-License-Identifier: Apache-2.0
// Where the weights of nets are found, how those that are nowhere are made, and those of a scene.

#pragma once

#include "cli/options.hpp"

#include <string>
#include <vector>

namespace elastogen {

/// Folders that are looked through in turn: that of the environment variable ELASTOGEN_WEIGHTS,
/// the user's cache (XDG_CACHE_HOME or ~/.cache, elastogen/weights), that beside an installed
/// program, that of the sources.
std::vector<std::string> weight_folders();

/// Path of the weight file of a law at a Poisson ratio, "" if no folder has one.
std::string find_weights(Law law, double poisson);

/// The net of a material, for Poisson ratios to 0.499, exponents of Ogden from -4 to 8 and limits
/// of Gent from 12 on: beyond, fits miss their limits. One that no folder has is fitted in about a
/// second, its last layer by Levenberg-Marquardt on the shipped hidden layers, and kept in the
/// user's cache under the hash of these layers; a cache that cannot be written or read is done
/// without.
/// @throws Error (usage) naming the material that is beyond, or whose fit misses its limits, or
///         where there are no hidden layers to fit on; (asset) for a file that read_weights
///         refuses.
std::shared_ptr<const LearnedLaw> net_of(const Material& material, Evaluation evaluation);

/// The nets of a scene's materials; none where the options ask for the laws. With energy auto a
/// material without a net is left to its law, null, if all are there are none.
/// @param notes  gets a sentence for each such material.
/// @throws Error as net_of, with energy neural.
LearnedLaws scene_nets(const Scene& scene, const AnimateOptions& options,
                       std::vector<std::string>& notes);

}  // namespace elastogen
