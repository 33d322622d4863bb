// SPDX-License-Identifier: Apache-2.0
// Pins, holds, tractions and moves of a run on the nodes of finite elements.

#pragma once

#include "mpm_fem/fem_scene.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// 1 for pinned nodes and middles of edges between two of them, (nodes, 1).
Array<uint8_t> pinned_nodes(const Scene& scene, const fem::ElementMesh& mesh);

/// Fills fixed, traction and motion of a scene that has its mesh. In a static run the motion at a
/// load factor is that at this share of the last key's time.
/// @throws Error (usage) naming the selections: where a node is moved and held, or moved twice, and
///         where no face lies in that of a traction.
void add_boundary(const Setup& setup, const RunDescription& run, fem::FemScene& scene);

/// A sentence for each piece of the mesh of which no component of the displacement is prescribed
/// along some axis: statics have no equilibrium for it unless its loads cancel. The first few
/// pieces, and how many there are besides.
std::vector<std::string> unheld_pieces(const fem::FemScene& scene);

}  // namespace elastogen
