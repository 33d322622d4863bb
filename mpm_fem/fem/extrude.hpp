// SPDX-License-Identifier: Apache-2.0
// Body-fitted meshes of boxes and of quadrilaterals extruded along z, on mapped lattices. Polygons:
// mpm_fem/fem/extrude_polygon.hpp; curved bodies come from a mesh generator's file
// (io/tets/tet_reader.hpp).

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

#include <array>
#include <vector>

namespace elastogen::fem {

using Vec2 = std::array<double, 2>;

/// Planes that bound cells from lower to upper [m], (cells + 1); the lengths of cells grow
/// geometrically.
/// @param ratio  length of the last cell over that of the first; 1: all equal.
/// @throws Error unless cells >= 1, lower < upper and ratio > 0.
std::vector<double> graded(int cells, double lower, double upper, double ratio = 1);

/// Kuhn tetrahedra (six for each cell, kTet4, material 0) between planes x, y, z [m]; nodes with x
/// fastest.
/// @throws Error unless each axis has two planes or more, finite and ascending.
ElementMesh box_tets(const std::vector<double>& x, const std::vector<double>& y,
                     const std::vector<double>& z);
/// box_tets of nx x ny x nz equal cells.
ElementMesh box_tets(int nx, int ny, int nz, const Vec3& lower, const Vec3& upper);

/// A convex quadrilateral with straight edges, mapped bilinearly from nx x ny cells and extruded
/// over 0 <= z <= thickness in nz layers; material 0. Node i + (nx + 1) (j + (ny + 1) k) lies at
/// the shares i / nx, j / ny, k / nz; quadratic elements have straight edges, and their middle
/// nodes come after all others.
/// @param corners  [m], counterclockwise; nx cells lie between the first two.
/// @param element  any but kVoxel.
/// @throws Error unless the quadrilateral is convex and counterclockwise, the thickness positive,
///         and each count at least 1.
ElementMesh extruded_quadrilateral(const std::array<Vec2, 4>& corners, double thickness, int nx,
                                   int ny, int nz, Element element);

}  // namespace elastogen::fem
