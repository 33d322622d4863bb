// SPDX-License-Identifier: Apache-2.0
// The options that verbs share.

#pragma once

#include "cli/typed.hpp"

namespace CLI {
class App;
}

namespace elastogen {

/// All that describes a scene: outputs, material, loads, time, solver, limits.
void add_scene_groups(CLI::App& app, AnimateOptions& options, Typed& typed);

/// What voxelising needs: resolution, size, limits.
void add_resolution_options(CLI::App& app, AnimateOptions& options, Typed& typed);

}  // namespace elastogen
