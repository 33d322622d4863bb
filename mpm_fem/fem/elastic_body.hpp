// SPDX-License-Identifier: Apache-2.0
// The elastic potential of a mesh in float64,
//
//     E(u) = sum_e sum_q w_q psi(F_q),    F_q = I + sum_a u_a (x) dN_a/dX(X_q),
//
// with its exact gradient and Hessian. With bbar F_q is multiplied by (Jbar/J_q)^(1/3), Jbar the
// mean of J over the element (mean dilatation: Nagtegaal et al. 1974; Simo, Taylor, Pister 1985),
// which keeps E a potential (below J = 1/10 it is continued: fem/mean_dilatation.hpp). The voxel
// element is that of docs/physics.md: one point with the mean gradient over the fill, and the
// strain-variance term with the torsion correction. The fill is a factor on energy and mass of
// voxels.

#pragma once

#include "core/constitutive.hpp"
#include "core/report.hpp"
#include "mpm_fem/fem/element_tables.hpp"
#include "mpm_fem/fem/point_gradients.hpp"
#include "mpm_fem/fem/voxel_element.hpp"

#include <vector>

namespace elastogen::fem {

/// Displacements u are (nodes, 3) [m] from mesh.rest throughout. Const members may be called from
/// several threads at once; results have the same bits on any number of threads.
class ElasticBody {
 public:
  /// @throws Error as check_mesh, and on a material index without material.
  ElasticBody(const ElementMesh& mesh, std::vector<Material> materials);

  const ElementMesh& mesh() const { return tables_.mesh(); }
  const std::vector<Material>& materials() const { return materials_; }

  /// Freezes the rotation of each voxel at u, in which its torsion correction is evaluated; before
  /// the first call it is I. A voxel whose F determines no rotation beyond rounding
  /// (core/polar.hpp) goes without the correction. Does nothing for other elements.
  void freeze_rotations(In<double> u);

  /// E(u) [J], in the parts elastic and hourglass. It is finite everywhere, because laws are
  /// continued below J = 0 (core/elastic_law.hpp).
  EnergyParts energy(In<double> u) const;
  /// Adds dE/du [N] to g, (nodes, 3).
  void add_gradient(In<double> u, Out<double> g) const;
  /// Hessian of one element [N/m], symmetric, row-major (3 n, 3 n), dof 3 corner + component.
  /// kProjected: the nearest positive semi-definite matrix, Gauss point by Gauss point where the
  /// element is their sum, else of the element's matrix.
  void element_hessian(int64_t element, In<double> u, TangentKind kind, double* K) const;

  /// Consistent mass of one element [kg], row-major (n, n); a partly filled voxel has the fill
  /// times the mass of a full one.
  void element_mass(int64_t element, double* M) const;
  /// Lumped mass of each node [kg], (nodes, 1): row sums of the mass matrix. Those of tet10 are
  /// negative at corners, so it has the diagonal, scaled to the mass of the element (Hinton, Rock,
  /// Zienkiewicz 1976). Voxels have rho phi h^3 Nbar_c, the row sums over the filled part, which
  /// equals Scene::mass where the grid has no volume to be scaled to.
  Array<double> lumped_mass() const;

  /// Mean of F over each element, (elements, 9).
  Array<double> deformation_gradient(In<double> u) const;
  /// Mean of Cauchy's stress P F^T/J over each element's rest volume [Pa], xx yy zz xy yz zx,
  /// (elements, 6); with bbar at Fbar, for voxels without strain-variance term and torsion.
  Array<double> cauchy_stress(In<double> u) const;
  /// Smallest det F of a quadrature point (with bbar of F, not Fbar).
  double min_j(In<double> u) const;
  /// Rest volume of each element, fill included [m^3], (elements, 1).
  Array<double> volume() const;

 private:
  const Material& material_of(int64_t element) const;
  ElasticLaw<double> law_of(int64_t element) const;
  VoxelHourglass hourglass(int64_t voxel) const;
  void element_lumped_mass(int64_t element, double* m) const;

  ElementTables tables_;
  std::vector<Material> materials_;
  Array<double> rotation_;  ///< of each voxel's torsion correction, (elements, 9); else empty
};

}  // namespace elastogen::fem
