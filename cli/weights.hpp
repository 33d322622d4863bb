// SPDX-License-Identifier: Apache-2.0
// Where the weights of nets are found, and those of a scene.

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

/// The nets of a scene's materials where the options ask for them, else none.
/// @throws Error (usage) naming the material that has none, with the Poisson ratios that there are;
///         (asset) for a file that read_weights refuses.
LearnedLaws scene_nets(const Scene& scene, const AnimateOptions& options);

}  // namespace elastogen
