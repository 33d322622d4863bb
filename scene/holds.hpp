// SPDX-License-Identifier: Apache-2.0
// Parts that are held along some axes only (Scene::fixed). Nodes in them are held: the body beyond a
// border that cuts voxels is not taken away, as it moves along the other axes.

#pragma once

#include "scene/set_up.hpp"

namespace elastogen {

/// Fixes components of free nodes, where the run's steps are those of the network; finite elements do it
/// by themselves (fem_boundary.cpp). Warns of holds that hold nothing, or whose border cuts voxels.
/// Comes after pin().
/// @throws Error (usage) naming a hold and a move that have a node in common.
void fix_axes(const RunDescription& run, Setup& setup);

}  // namespace elastogen
