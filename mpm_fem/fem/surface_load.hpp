// SPDX-License-Identifier: Apache-2.0
// A force on a part of a body's surface as consistent loads of its nodes.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// Loads [N], (nodes, 3), of a force that is spread evenly over the faces with one element whose
/// corners are all selected:
///
///     f_a = force sum_faces int N_a dA / sum_faces A.
///
/// A quadrilateral (a parallelogram) gives its corners a quarter each, a triangle a third, one of a
/// quadratic element its middles a third and its corners nothing. A face of a partly filled voxel
/// counts with the fill, that of the voxel element with its shape function means, so that the
/// traction of a uniform stress is in equilibrium with it.
/// @param selected  1 where a node is selected, (nodes, 1); of quadratic elements middles are not
///                  looked at
/// @return          empty if there is no such face
/// @throws Error unless selected has a row a node.
Array<double> surface_load(const ElementMesh& mesh, In<uint8_t> selected, const Vec3& force);

}  // namespace elastogen::fem
