// SPDX-License-Identifier: Apache-2.0
// A scene file as options of the command, and the options as a scene.

#pragma once

#include "cli/options.hpp"
#include "io/scene_value.hpp"

namespace elastogen {

/// What a scene would have typed: the texts of one option, one each time it is given.
struct SceneOption {
  std::string option;
  std::vector<std::string> texts;
};

/// @param scene  checked, as read_scene gives it.
std::vector<SceneOption> scene_options(const SceneValue& scene);

/// Every key of a scene file with the value that it has, in SI; regions, colliders, holds,
/// tractions and moves as texts.
SceneValue resolved_scene(const AnimateOptions& options);

}  // namespace elastogen
