// SPDX-License-Identifier: Apache-2.0
// Bodies with smooth boundaries as images of a box: body-fitted quadratic tetrahedra with curved
// edges, and the same boundary as triangles for the voxeliser.

#pragma once

#include "io/asset.hpp"
#include "mpm_fem/fem/element_mesh.hpp"

#include <array>
#include <functional>

namespace elastogen::test {

struct MappedBody {
  /// Axes that run over [-1, 1], in two halves that mirror each other; the others run over [0, 1].
  std::array<bool, 3> mirrored = {};
  std::array<int, 3> cells = {1, 1, 1};  ///< along [0, 1] of each axis, of the coarsest mesh
  /// The place of a point of the box [m]. It may have kinks where two coordinates have one size:
  /// tetrahedra have faces there.
  std::function<Vec3(const Vec3& p)> map;
};

/// The box in n times its cells, each cut into six tetrahedra around the diagonal that points away
/// from the middle (so that an edge of the box that the map makes flat is cut in two), all ten
/// nodes of each mapped.
/// @param octant  the part of positive coordinates only.
fem::ElementMesh mapped_tets(const MappedBody& body, int n, bool octant = false);

/// The boundary of the whole body, two triangles to each face of a cell, outward.
Surface mapped_surface(const MappedBody& body, int n);

/// Smallest 6 sqrt(2) det J / (rms edge)^3 of a tetrahedron at its corners and middles of edges, J
/// of the curved element: 1 for the regular one, 0 or less where it turns over.
double worst_shape(const fem::ElementMesh& tets);

/// The unit square or cube to the unit disc or ball: p (s (1 - m^2) + m^3/|p|), m the largest
/// coordinate's size; like itself near the middle, round at the border.
/// @param p  2 or 3 numbers, overwritten
void to_ball(double* p, int dimensions);

}  // namespace elastogen::test
