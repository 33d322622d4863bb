// SPDX-License-Identifier: Apache-2.0
// A scene of edge 2h from one of edge h (coarse_grid.hpp): its masses, materials and what is held.

#pragma once

#include "core/scene.hpp"
#include "network/mesh_number/coarse_grid.hpp"

namespace elastogen {

struct CoarseScene {
  CoarseGrid transfer;     ///< without its grid, which is that of the scene
  NodeFit fit;             ///< from h to 2h
  Scene scene;             ///< without gravity and colliders; mass = P^T that of h
  Array<uint8_t> fixed;    ///< 1 where a component does not move, (nodes, 3)
  bool has_rails = false;  ///< a node is fixed in some components only
};

/// The scene of edge 2h. A voxel is of the material of its heaviest child. A component is fixed
/// where it is at the same place on h; where there is no such node, if most of P around is.
/// @param fixed  1 where a component is held or moved by the scene, (fine nodes, 3).
/// @param dt     of the coarse scene [s].
CoarseScene coarse_scene(const Scene& fine, const Array<uint8_t>& fixed, double dt);

}  // namespace elastogen
