// SPDX-License-Identifier: Apache-2.0
// What statics and implicit steps minimise over the displacements that are free,
//
//     Phi(u) = E(u) + E_contact(u) - f.u + a/2 (u - uhat).M (u - uhat),
//
// E of ElasticBody, f dead loads, M the mass; statics have a = 0 and no contact.

#pragma once

#include "mpm_fem/solve/linear_solver.hpp"
#include "mpm_fem/solve/mass_matrix.hpp"
#include "mpm_fem/solve/newton.hpp"

namespace elastogen::fem {

class IncrementalPotential {
 public:
  /// The scene must outlive the potential.
  /// @throws Error as ElasticBody and MassMatrix, and unless fixed is (nodes, 3) or empty.
  explicit IncrementalPotential(const FemScene& scene, const LinearOptions& options = {});

  ElasticBody& body() { return body_; }
  const ElasticBody& body() const { return body_; }
  const MassMatrix& mass() const { return mass_; }
  const Assembly& assembly() const { return assembly_; }
  const LinearSolver& solver() const { return solver_; }
  int64_t unknowns() const { return 3 * scene_.mesh.rest.rows(); }
  bool is_fixed(int64_t unknown) const { return fixed_[size_t(unknown)] != 0; }

  ColliderContact& contact() { return contact_; }
  double edge() const { return edge_; }                   ///< mean edge of an element [m]
  void set_force(In<double> force);                       ///< f [N], (nodes, 3)
  void set_inertia(double weight, In<double> predictor);  ///< a [1/s^2], uhat [m], (nodes, 3)

  /// Phi [J] with the bound on its rounding error,
  ///
  ///     eps (32 sum of the parts + 4 sqrt(2 S E) (1 + |u|/l)),  S = sum_e V_e (2 mu + lambda):
  ///
  /// stretches are rounded by eps (1 + |u|/l), l the mean edge of an element. The gradient [N] is 0
  /// at what is fixed.
  NewtonValue evaluate(const double* u, double* gradient);
  /// The same gradient with the forces that hold what is fixed.
  void full_gradient(const double* u, double* gradient);

  /// step = -H^-1 gradient; its fixed components are those of `moved` or, if null, 0. A projected
  /// Hessian that is still not positive definite is shifted by a small share of its diagonal.
  /// @return false where H is not positive definite
  bool newton_step(const double* u, const double* gradient, bool projected, double tolerance,
                   const double* moved, double* step);

  /// eps | |H| (|u| + l) |, with the Hessian of the last newton_step: what the rounding of u and of
  /// the stretches leaves of the gradient [N].
  double gradient_noise(const double* u) const;

  /// Moves u to a minimum of Phi.
  NewtonResult minimise(const NewtonOptions& options, double* u);
  /// Moves the fixed components of u to those of target, the others along with them to first order.
  void move_fixed(In<double> target, double* u);

 private:
  void assemble(const double* u, bool projected);
  bool factor_shifted();

  const FemScene& scene_;
  ElasticBody body_;
  Assembly assembly_;
  MassMatrix mass_;
  ColliderContact contact_;
  std::vector<uint8_t> fixed_;
  double weight_ = 0;
  std::vector<double> force_, predictor_;
  std::vector<double> away_, mass_away_, right_;  // work
  SparseMatrix hessian_;
  LinearSolver solver_;
  double edge_ = 0;       // l [m]
  double stiffness_ = 0;  // S [J]
};

}  // namespace elastogen::fem
