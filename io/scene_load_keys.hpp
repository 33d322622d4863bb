// SPDX-License-Identifier: Apache-2.0
// The keys of io/scene_keys.hpp that hold, load and move a body.

#pragma once

#include "io/scene_keys.hpp"

namespace elastogen {

std::vector<SceneKey> load_keys();

}  // namespace elastogen
