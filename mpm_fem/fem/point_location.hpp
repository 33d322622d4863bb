// SPDX-License-Identifier: Apache-2.0
// The tetrahedron that holds a point, and the shape functions there.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// The tetrahedron of [begin, end) whose smallest barycentric coordinate at a point is largest: the
/// one that holds it, or is nearest in that measure.
/// @param point    [m], 3 numbers
/// @param weights  shape functions of the element's nodes at the point, 4 or 10, sum 1; outside the
///                 element they are extrapolated.
int64_t locate(const ElementMesh& mesh, int64_t begin, int64_t end, const double* point,
               double* weights);

}  // namespace elastogen::fem
