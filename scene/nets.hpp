// SPDX-License-Identifier: Apache-2.0
// Where the weights of nets are found, and the nets of a scene's materials.

#pragma once

#include "network/law/learned_law.hpp"
#include "scene/description.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace elastogen {

/// Folders that are looked through in turn: that of the environment variable ELASTOGEN_WEIGHTS,
/// the user's cache, that beside an installed program, that of the sources.
std::vector<std::string> weight_folders();

/// Folder of the user's cache, XDG_CACHE_HOME or ~/.cache, elastogen/weights; "" without a home.
std::string weight_cache();

/// Path of a file of that name in the first folder that has one, "" if none has.
std::string find_weight_file(const std::string& name);

/// Nets are made for Poisson ratios to 0.499, exponents of Ogden from -4 to 8 and limits of Gent
/// from 7.5 on: beyond, fits miss their limits (docs/materials.md).
/// @throws Error (usage) naming the material that is beyond.
void check_has_net(const Material& material);

/// Makes the net of a material that has no weight file. @throws Error (usage) saying why not.
using NetMaker = std::function<std::shared_ptr<const LearnedLaw>(const Material& material,
                                                                 Evaluation evaluation)>;

/// The nets of a scene's materials, by LAW-POISSON.weights of the first folder that has it, else by
/// the maker; none where the run asks for the laws. With energy auto a material without a net is
/// left to its law, null; if all are, there are none.
/// @param make_net  empty: a material without a file has no net.
/// @param notes     gets a sentence for each material that is left to its law.
/// @throws Error (usage) as check_has_net and the maker, with energy neural; (asset) for a file
/// that
///         read_weights refuses.
LearnedLaws scene_nets(const Scene& scene, const RunDescription& run, const NetMaker& make_net,
                       std::vector<std::string>& notes);

}  // namespace elastogen
