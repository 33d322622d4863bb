// SPDX-License-Identifier: Apache-2.0
// The TOML half of io/scene_text.hpp.

#pragma once

#include "io/scene_value.hpp"

namespace elastogen {

/// @throws Error (usage) as parse_scene.
SceneValue parse_scene_toml(std::string_view text, const std::string& name);

}  // namespace elastogen
