// SPDX-License-Identifier: Apache-2.0
// Scenes that fill their box in part, and the scenes of the verb by name.

#pragma once

#include "bench/scenes.hpp"

namespace elastogen::bench {

/// The cantilever reduced to struts along x, y and z that cross each other: w voxels thick, p apart
/// in each direction, with 3 (w/p)^2 - 2 (w/p)^3 as near as possible to the wanted share of the
/// box.
/// @param fill  0.01 ... 1; 1 is the cantilever itself.
/// @throws Error for other shares.
Scene lattice(const SceneOptions& options, double fill);

/// beam (a lattice if the fill is below 1), ball, and c84: the cantilever with E = 1e5 Pa at 30
/// steps a second, for any Courant number. @throws Error naming them.
Scene step_scene(const std::string& name, const SceneOptions& options, double fill);

}  // namespace elastogen::bench
