// SPDX-License-Identifier: Apache-2.0
// Keys of scene files about bodies without a file and about particles; part of scene_keys().

#pragma once

#include "io/scene_keys.hpp"

namespace elastogen {

/// Keys of the table shape.
std::vector<SceneKey> shape_keys();
/// Keys of the table particles.
std::vector<SceneKey> particle_keys();

}  // namespace elastogen
