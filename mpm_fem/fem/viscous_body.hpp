// SPDX-License-Identifier: Apache-2.0
// Damping of a mesh by the loss factors of its materials (core/viscous.hpp), as the part
//
//     D(u) = sum_e sum_q w_q beta (mu |E - E_b|^2 + lambda/2 tr(E - E_b)^2)
//          + sum_voxels beta phi h/2 [ sum_p c_p |A_p - A_b,p|^2/24 + c_xyz |A_xyz - A_b,xyz|^2/48 ]
//
// of the potential of a step, beta = tau rate, with E at the F_q of the law (with bbar at Fbar_q) and
// A_p = F^T q_p what varies within a voxel, in the frame of the material (fem/voxel_element.hpp).
// E' = rate (E - E_b): the power that is lost is 2 rate D.

#pragma once

#include "core/material.hpp"
#include "core/tangent.hpp"
#include "core/viscous.hpp"
#include "mpm_fem/fem/element_tables.hpp"

#include <vector>

namespace elastogen::fem {

/// Whether a material is damped.
bool is_damped(const Material& material);

/// Displacements and threads as of ElasticBody.
class ViscousBody {
 public:
  /// @throws Error as check_mesh, and on a material index without material.
  ViscousBody(const ElementMesh& mesh, std::vector<Material> materials);

  const ElementMesh& mesh() const { return tables_.mesh(); }

  /// Begins a step: E_b = E(u) + weight (E(other) - E(u)), and A_b likewise.
  /// @param rate   [1/s]
  /// @param other  not read where the weight is 0
  void begin(double rate, In<double> u, double weight, In<double> other);
  /// Another rate from the same E_b.
  void set_rate(double rate) { rate_ = rate; }
  double rate() const { return rate_; }
  /// sum_e V_e beta (2 mu + lambda) [J].
  double stiffness() const;

  double energy(In<double> u) const;  ///< D [J]
  /// Adds dD/du [N] to g, (nodes, 3).
  void add_gradient(In<double> u, Out<double> g) const;
  /// Hessian of one element as of ElasticBody. kProjected: without what the stress and A - A_b add
  /// to it, which is the smaller, the less a step changes E; with bbar the positive part.
  void element_hessian(int64_t element, In<double> u, TangentKind kind, double* K) const;

 private:
  struct Within;  // what varies within a voxel

  const Material& material_of(int64_t element) const;
  ViscousModuli<double> moduli(int64_t element) const;
  bool varies() const;
  void find_strains(In<double> u, Array<double>& strain) const;
  Within within(int64_t voxel, const ElementState& e) const;

  ElementTables tables_;
  std::vector<Material> materials_;
  double rate_ = 0;
  Array<double> before_;  ///< E_b of the points, then A_b: (elements, 6 points + 12 of a voxel)
};

}  // namespace elastogen::fem
