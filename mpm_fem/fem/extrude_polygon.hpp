// SPDX-License-Identifier: Apache-2.0
// Body-fitted tetrahedra of polygons extruded along z.

#pragma once

#include "mpm_fem/fem/extrude.hpp"

#include <vector>

namespace elastogen::fem {

/// A simple polygon, convex or not, cut into triangles by its ears (Meisters 1975), first the ear
/// with the largest least angle; each triangle is then cut into 4^refinements equal ones. Triangles
/// are counterclockwise, (triangles, 3); the first of their points [m] are the corners.
struct PolygonMesh {
  std::vector<Vec2> points;
  std::vector<std::array<int32_t, 3>> triangles;
};
/// @param corners  [m], clockwise or counterclockwise.
/// @throws Error naming the place: fewer than three corners, one that is not finite, edges without
///         length, edges that touch or cross; refinements beyond 0 ... 10.
PolygonMesh polygon_mesh(const std::vector<Vec2>& corners, int refinements);

/// The polygon extruded over 0 <= z <= thickness: each prism of a layer is cut into three
/// tetrahedra by diagonals that rise from the lower to the higher number of a point, so that all
/// conform; material 0. Node p + points k lies above point p at the share k / layers; quadratic
/// elements have straight edges, and their middle nodes come after all others.
/// @param element  kTet4, kTet10 or kTet10Bbar.
/// @throws Error as polygon_mesh, and unless the thickness is positive and there is a layer.
ElementMesh extruded_polygon(const std::vector<Vec2>& corners, double thickness, int refinements,
                             int layers, Element element);

}  // namespace elastogen::fem
