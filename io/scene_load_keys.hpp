// SPDX-License-Identifier: Apache-2.0
// Keys of scene files that hold, load and move a body; part of io/scene_keys.hpp.

#pragma once

#include "io/scene_keys.hpp"

namespace elastogen {

std::vector<SceneKey> load_keys();

}  // namespace elastogen
