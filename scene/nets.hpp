// SPDX-License-Identifier: Apache-2.0
// Finds the files of weights, and the nets of a scene's materials.

#pragma once

#include "network/law/learned_law.hpp"
#include "scene/description.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace elastogen {

/// Folders that are searched in turn: that of the environment variable ELASTOGEN_WEIGHTS, the
/// user's cache, the one beside an installed program, the one of the sources.
std::vector<std::string> weight_folders();

/// Folder of the user's cache, XDG_CACHE_HOME or ~/.cache, then elastogen/weights; "" without HOME.
std::string weight_cache();

/// Path of a file of that name in the first folder that has one, "" if none has.
std::string find_weight_file(const std::string& name);

/// Nets exist for Poisson ratios up to 0.499, exponents of Ogden from -4 to 8 and limits of Gent
/// from 7.5. Outside these ranges fits miss their limits (docs/materials.md).
/// @throws Error (usage) naming a material outside.
void check_has_net(const Material& material);

/// Makes the net of a material that has no weight file. @throws Error (usage) saying why not.
using NetMaker = std::function<std::shared_ptr<const LearnedLaw>(const Material& material,
                                                                 Evaluation evaluation)>;

/// The nets of a scene's materials: from LAW-POISSON.weights in the first folder that has it, else
/// from make_net; none if the run asks for the laws. With energy auto a material without a net uses
/// its law (null); if all do, the result is empty.
/// @param make_net  empty: a material without a file has no net.
/// @param notes     gets a sentence for each material that uses its law.
/// @throws Error (usage) as check_has_net and make_net, with energy neural; (asset) for a file that
///         read_weights refuses.
LearnedLaws scene_nets(const Scene& scene, const RunDescription& run, const NetMaker& make_net,
                       std::vector<std::string>& notes);

}  // namespace elastogen
