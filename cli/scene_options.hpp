// SPDX-License-Identifier: Apache-2.0
// A scene file as options of the command, and the options as a scene.

#pragma once

#include "cli/options.hpp"
#include "io/scene_value.hpp"

namespace elastogen {

/// One option that a scene stands for: its texts, one for each time it is given.
struct SceneOption {
  std::string option;
  std::vector<std::string> texts;
};

/// @param scene  a checked scene, as read_scene returns it.
std::vector<SceneOption> scene_options(const SceneValue& scene);

/// Every key of a scene file with its value in SI; regions, colliders, holds, tractions and moves
/// as texts.
SceneValue resolved_scene(const AnimateOptions& options);

}  // namespace elastogen
