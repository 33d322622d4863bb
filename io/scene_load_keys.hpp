// SPDX-License-Identifier: Apache-2.0
// Keys of scene files that hold, load and move a body; part of io/scene_keys.hpp.

#pragma once

#include "io/scene_keys.hpp"

namespace elastogen {

std::vector<SceneKey> load_keys();

/// Keys that select a part, of which each entry of the table has one.
std::vector<SceneKey> selection_keys(const char* table);

}  // namespace elastogen
