// SPDX-License-Identifier: Apache-2.0
// The terms of the voxel element of docs/physics.md besides its point with the mean gradient over
// the fill: the strain-variance term, with the torsion correction in the rotation R,
//
//     E = phi h/2 [ sum_p c_p |q_p|^2/24 + c_xyz |q_xyz|^2/48 ]                      p = xy, yz, zx
//       + phi h/96 [ mu ((a+b)^2 + (b+d)^2 + (d+a)^2) - 2 (c_yz a^2 + c_zx b^2 + c_xy d^2) ],
//     a = (R^T q_yz)_x,  b = (R^T q_zx)_y,  d = (R^T q_xy)_z,
//
// quadratic in u and positive semi-definite: the part that the second line subtracts is contained
// in the first, since |q_p| = |R^T q_p|.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// The means over the fill of dN_c/dX_d = s_cd (Nbar_c + Nbar_c')/h, c' = c mirrored along d, from
/// the means Nbar of the shape functions, (8, 3) [1/m].
void voxel_gradient(const double* shape_mean, double h, double* gradient);

/// The patterns xy, yz, zx, xyz as vectors of the corners, re-centred at the centroid of the fill: a
/// component of u has q_p = pattern_p . u.
void voxel_patterns(const double* shape_mean, double pattern[4][8]);

/// E as 1/2 sum_k weight_k (row_k . u)^2 over the 24 displacements u, dof 3 corner + component.
struct VoxelHourglass {
  int count = 0;
  double row[18][24];
  double weight[18];  ///< [N/m]
};

/// @param R  rotation of the torsion correction, row-major; 0: without the correction.
VoxelHourglass voxel_hourglass(const ElementMesh& mesh, int64_t voxel, double mu, const double* R);

/// E [J] at displacements u (8, 3).
double hourglass_energy(const VoxelHourglass& hourglass, const double* u);
/// Adds dE/du [N] to f, (8, 3).
void add_hourglass_gradient(const VoxelHourglass& hourglass, const double* u, double* f);
/// Adds the Hessian [N/m] to K, row-major (24, 24).
void add_hourglass_hessian(const VoxelHourglass& hourglass, double* K);

}  // namespace elastogen::fem
