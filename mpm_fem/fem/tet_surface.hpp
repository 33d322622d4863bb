// SPDX-License-Identifier: Apache-2.0
// The surface of a mesh of tetrahedra.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// Faces with one tetrahedron as triangles of nodes, counterclockwise from outside, in the order of
/// their tetrahedra; of quadratic ones four a face, between corners and middles.
/// @return  (triangles, 3)
/// @throws Error unless the mesh has tetrahedra.
Array<int32_t> outer_triangles(const ElementMesh& mesh);

/// Edge of the cube that six tetrahedra of mean volume fill, (6 V / elements)^(1/3) [m]: what h is
/// for voxels. Edges count as straight.
double mean_edge(const ElementMesh& mesh);

}  // namespace elastogen::fem
