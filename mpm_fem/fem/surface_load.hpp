// SPDX-License-Identifier: Apache-2.0
// A force or a pressure on a part of a body's surface as consistent loads of its nodes. Both act on
// the faces with one element whose corners are all selected.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// Loads [N], (nodes, 3), of a force that is spread evenly over the faces:
///
///     f_a = force sum_faces int N_a dA / sum_faces A.
///
/// A quadrilateral (a parallelogram) gives each corner a quarter, a triangle a third. A triangle of
/// a quadratic element counts as flat, and gives each middle a third and its corners nothing. A
/// face of a partly filled voxel counts with the fill, and a face of the voxel element with the
/// means of its shape functions, so that the traction of a uniform stress is in equilibrium with
/// the stress.
/// @param selected  1 where a node is selected, (nodes, 1); middles of quadratic elements do not
///                  matter
/// @return          empty if there is no such face
/// @throws Error unless selected has a row for each node.
Array<double> surface_load(const ElementMesh& mesh, In<uint8_t> selected, const Vec3& force);

/// Loads [N], (nodes, 3), of a pressure [Pa] against the outward normals n of the faces at rest:
///
///     f_a = -pressure sum_faces int N_a n dA,
///
/// exact for faces of quadratic tetrahedra that curve with their middles: on a closed surface force
/// and moment vanish. On voxels it acts on the faces of the grid, and those of partly filled voxels
/// count as in surface_load. That is too little where the surface cuts a voxel across the pressure:
/// a closed surface whose voxels differ in fill is left with a force.
/// @param selected  as in surface_load
/// @return          empty if there is no such face
/// @throws Error unless selected has a row for each node and the pressure is finite.
Array<double> pressure_load(const ElementMesh& mesh, In<uint8_t> selected, double pressure);

}  // namespace elastogen::fem
