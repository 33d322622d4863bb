// SPDX-License-Identifier: Apache-2.0
// The keys of scene files for materials and regions.

#pragma once

#include "io/scene_keys.hpp"

namespace elastogen {

/// Keys of [material] and of [[region]], in the order of the page.
std::vector<SceneKey> main_material_keys();
std::vector<SceneKey> region_keys();

}  // namespace elastogen
