// SPDX-License-Identifier: Apache-2.0
// The reference elements: shape functions and quadrature rules.
//
// The hexahedron is the unit cube [0, 1]^3, the tetrahedron xi, eta, zeta >= 0 with a sum of at
// most 1, the triangle its face zeta = 0; nodes in the order of fem/element_mesh.hpp. The voxel has
// the functions of the hexahedron.

#pragma once

#include "core/base.hpp"
#include "mpm_fem/fem/element_mesh.hpp"

#include <vector>

namespace elastogen::fem {

inline constexpr int kMaxNodes = 10;  ///< of an element
inline constexpr int kMaxDofs = 3 * kMaxNodes;
inline constexpr int kMaxPoints = 8;  ///< of the rule for the potential

/// N_a(xi), (nodes_of(element)).
void shape_functions(Element element, const Vec3& xi, double* N);
/// dN_a/dxi, (nodes_of(element), 3).
void shape_gradients(Element element, const Vec3& xi, double* dN);

/// dX/dxi of an element with nodes X, (nodes_of(element), 3) [m]; row-major 3x3. Across a triangle
/// it is 1 m, its thickness.
void jacobian(Element element, const double* X, const double* dN, double J[9]);

struct QuadraturePoint {
  Vec3 xi;
  double weight;
};

/// The rule for the potential: Gauss 2x2x2 for hexahedra (degree 3 in each direction), 1 point for
/// tet4 and tri3 (degree 1), 4 points for tet10 (degree 2). Weights sum to the reference volume.
const std::vector<QuadraturePoint>& potential_rule(Element element);

/// The rule for the mass: Gauss 3x3x3 for hexahedra, 14 points of degree 5 for tetrahedra
/// (Grundmann, Moeller 1978; Walkington 2000), the middles of the edges of triangles (degree 2);
/// exact for N_a N_b on elements with straight edges.
const std::vector<QuadraturePoint>& mass_rule(Element element);

}  // namespace elastogen::fem
