// SPDX-License-Identifier: Apache-2.0
// Scenes whose box is filled in part, and the scenes of the verb by their name.

#pragma once

#include "bench/scenes.hpp"

namespace elastogen::bench {

/// The cantilever cut down to struts along x, y and z that cross each other: w voxels thick, p
/// apart in each direction, with 3 (w/p)^2 - 2 (w/p)^3 nearest to the share of the box that is
/// wanted.
/// @param fill  0.01 ... 1; 1 is the cantilever itself.
/// @throws Error for other shares.
Scene lattice(const SceneOptions& options, double fill);

/// beam (a lattice where the fill is below 1), ball, and c84: the cantilever with E = 1e5 Pa at 30
/// steps a second, whatever the Courant number. @throws Error naming them.
Scene step_scene(const std::string& name, const SceneOptions& options, double fill);

}  // namespace elastogen::bench
