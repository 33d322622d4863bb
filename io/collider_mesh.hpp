// SPDX-License-Identifier: Apache-2.0
// The surface of a collider as triangles, for pictures and for scenes of other programs.

#pragma once

#include "core/array.hpp"
#include "core/collider.hpp"

namespace elastogen {

/// A surface whose triangles go counter-clockwise seen from the free side.
struct ColliderMesh {
  Array<double> position;    ///< [m], (vertices, 3)
  Array<double> normal;      ///< unit, to the free side, (vertices, 3)
  Array<int32_t> triangles;  ///< (triangles, 3)
};

/// The surface of a collider at its place without the offset of its path: a sphere of 48 meridians
/// and 24 zones, a box with normals of its faces, a plane as a square.
/// @param seen   box of the bodies around it [m]: the square stands below its middle, and its edges
///               are 1.5 times the longest extent of the box along the plane.
/// @throws Error (usage) if `seen` is empty or not finite; as check_collider.
ColliderMesh collider_mesh(const Collider& collider, const Box& seen);

}  // namespace elastogen
