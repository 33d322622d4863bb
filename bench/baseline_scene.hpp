// SPDX-License-Identifier: Apache-2.0
// Files exchanged with bench/baselines/elastogen_paper.py, which lists them.

#pragma once

#include "core/scene.hpp"
#include "core/state.hpp"
#include "network/solver.hpp"

#include <string>

namespace elastogen::bench {

/// Writes scene and state into a folder: the box of the voxels as dense arrays, x fastest.
/// @throws Error (usage) if dense arrays cannot hold the scene: border voxels, several
///         materials, a law other than neo-Hookean, an hourglass term other than variance, a body
///         one voxel thick.
void write_baseline_scene(const std::string& folder, const Scene& scene, const State& state,
                          const PaperLoops& loops);

/// Positions of the nodes [m], (nodes, 3), from the displacements that the baseline wrote.
/// @throws Error (asset) if the file is missing or has another size.
Array<double> read_baseline_positions(const std::string& folder, const Scene& scene);

}  // namespace elastogen::bench
