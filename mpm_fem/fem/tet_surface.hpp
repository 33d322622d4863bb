// SPDX-License-Identifier: Apache-2.0
// The surface of a mesh of tetrahedra; of plane triangles the triangles themselves.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// Corners of the faces of a tetrahedron, counterclockwise from outside, and the middles of their
/// edges: middle k lies between corners k and k + 1.
inline constexpr int kTetFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
inline constexpr int kTetFaceMiddles[4][3] = {{5, 9, 8}, {7, 9, 6}, {4, 8, 7}, {6, 5, 4}};

/// Faces with one tetrahedron as triangles of nodes, counterclockwise from outside, in the order of
/// their tetrahedra. A face of a quadratic one gives four, between corners and middles.
/// @return  (triangles, 3)
/// @throws Error unless the mesh has tetrahedra or triangles.
Array<int32_t> outer_triangles(const ElementMesh& mesh);

/// Edge of the cube that six tetrahedra of mean volume fill, (6 V / elements)^(1/3) [m], as h is
/// for voxels; for triangles that of the square that two of them fill. Edges count as straight.
double mean_edge(const ElementMesh& mesh);

/// Half the length of the edges with one triangle that end at each node of plane triangles, times
/// their thickness of 1 m: the node's share of the surface [m^2], (nodes, 1).
Array<double> rim_area(const ElementMesh& mesh);

}  // namespace elastogen::fem
