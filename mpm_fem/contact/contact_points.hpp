// SPDX-License-Identifier: Apache-2.0
// Points of a surface that colliders act on (docs/physics.md, section 6).

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// Points that move with nodes of a mesh.
struct ContactPoints {
  Array<int32_t> nodes;     ///< nodes that carry a point, (points, n)
  Array<double> weights;    ///< of each, rows sum to 1, (points, n)
  Array<double> area;       ///< [m^2], (points, 1)
  Array<double> position;   ///< at rest [m], (points, 3)
  Array<double> stiffness;  ///< E D^2 / h of the barrier [N/m], (points, 1)
  double layer = 0;         ///< D [m]
  double slip_range = 0;    ///< slip up to which friction counts as sticking [m]
};

/// The points of a voxel scene with its layer h/4 and its slip range, a thousandth of the body's
/// free-fall speed times dt; the corners of its voxel carry each point.
ContactPoints voxel_contact(const Scene& scene);

/// Nodes of a mesh as points, each as stiff as the stiffest of its elements; h of layer and slip
/// range is the scene's.
/// @param scene  with materials, grid.h, dt, and area and position of the points in its surface.
/// @param nodes  of each point, (points, 1).
ContactPoints node_contact(const Scene& scene, const ElementMesh& mesh, In<int32_t> nodes);

}  // namespace elastogen::fem
