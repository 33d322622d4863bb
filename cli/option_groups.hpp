// SPDX-License-Identifier: Apache-2.0
// Options that several verbs have.

#pragma once

#include "cli/typed.hpp"

namespace CLI {
class App;
}

namespace elastogen {

/// All options that describe a scene: outputs, material, loads, time, solver, limits.
void add_scene_groups(CLI::App& app, AnimateOptions& options, Typed& typed);

/// Options of voxelisation: resolution, size, limits.
void add_resolution_options(CLI::App& app, AnimateOptions& options, Typed& typed);

}  // namespace elastogen
