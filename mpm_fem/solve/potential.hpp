// SPDX-License-Identifier: Apache-2.0
// The function that statics and implicit steps minimise over the free displacements,
//
//     Phi(u) = sum_t E_t(u) - f.u + a/2 (u - uhat).M (u - uhat),
//
// E_t the terms (elements of meshes, contact, ...), f dead loads, M the mass; statics have a = 0.
// Dependent nodes follow free ones (constraint.hpp): gradient and Hessian have their part folded.
// The pattern of the Hessian is that of the terms' stencils, and changes with them.

#pragma once

#include "mpm_fem/solve/constraint.hpp"
#include "mpm_fem/solve/inertia.hpp"
#include "mpm_fem/solve/linear_solver.hpp"
#include "mpm_fem/solve/newton.hpp"
#include "mpm_fem/solve/nonsymmetric_solver.hpp"
#include "mpm_fem/solve/root.hpp"

#include <optional>

namespace elastogen::fem {

class Potential {
 public:
  /// Terms and rest must outlive the potential.
  /// @param rest   positions of all nodes at rest [m], (nodes, 3)
  /// @param fixed  1 where a component's displacement is prescribed, (nodes, 3); empty: none
  /// @param mass   of all nodes
  /// @param constraint  of dependent nodes, none of whose components is fixed
  /// @throws Error where these differ in length, a dependent node is fixed, and as pattern_of of the
  ///         terms' stencils
  Potential(In<double> rest, In<uint8_t> fixed, MassMatrix mass, std::vector<Term*> terms,
            const LinearOptions& options = {}, Constraint constraint = {});
  Potential(const Potential&) = delete;
  Potential& operator=(const Potential&) = delete;

  const MassMatrix& mass() const { return inertia_.mass(); }
  const LinearSolver& solver() const { return solver_; }
  int64_t unknowns() const { return rest_.size(); }
  bool is_fixed(int64_t unknown) const { return fixed_[size_t(unknown)] != 0; }
  /// Whether it is fixed, or of a dependent node.
  bool is_bound(int64_t unknown) const { return bound_[size_t(unknown)] != 0; }
  const Constraint& constraint() const { return constraint_; }
  /// The Hessian of the last newton_step, with the rows of fixed components and dependent nodes as
  /// fix_unknowns leaves them.
  const SparseMatrix& hessian() const { return hessian_; }

  void set_force(In<double> force);                       ///< f [N], (nodes, 3)
  void set_inertia(double weight, In<double> predictor);  ///< a [1/s^2], uhat [m], (nodes, 3)
  /// Sets where dependent nodes are to be (Constraint::set_offset); move_fixed moves them there.
  void set_offset(In<double> offset) { constraint_.set_offset(offset); }

  /// Phi [J] with the bound on its rounding error, eps (32 sum of the terms' sizes + sum of their
  /// roundings). The gradient [N] is 0 at fixed components and at dependent nodes, which u has in
  /// their places.
  NewtonValue evaluate(const double* u, double* gradient);
  /// The gradient in u itself, with the forces that hold fixed components and dependent nodes.
  void full_gradient(const double* u, double* gradient);
  /// The same; at fixed components that of the terms, with what the inertia of free components does
  /// to them where masses are coupled: without f, their own inertia and their weight.
  /// @param pull  acceleration within uhat [m/s^2]
  void held_gradient(const double* u, const Vec3& pull, double* gradient);
  /// The gradient of evaluate() alone.
  void free_gradient(const double* u, double* gradient);
  /// Turns the gradient in u into that of evaluate().
  void restrict(double* gradient) const;
  /// Gives the fixed components of a candidate their values `now`, and dependent nodes the change
  /// that their parent nodes have from there.
  void carry(const double* now, double* candidate) const;

  /// step = -H^-1 gradient; its fixed components are those of `moved` or, if null, 0, and dependent
  /// nodes follow, moved by their part of it besides. A projected Hessian that is still not positive
  /// definite is shifted by a small share of its diagonal.
  /// @return false where H is not positive definite
  bool newton_step(const double* u, const double* gradient, TangentKind kind, double tolerance,
                   const double* moved, double* step);

  /// eps | |H| (|u| + l) |, with the Hessian of the last newton_step and the longest length l of a
  /// term: the error of the gradient [N] by rounding of u and of the stretches.
  double gradient_noise(const double* u) const;

  /// Moves u to a minimum of Phi.
  NewtonResult minimise(const NewtonOptions& options, double* u);
  /// Moves u to where the gradient is 0, for terms whose gradient has no potential.
  RootResult find_root(const RootOptions& options, double* u);
  /// Iterations of GMRES in all find_root so far.
  int64_t root_iterations() const { return root_solver_ ? root_solver_->iterations() : 0; }
  /// Moves the fixed components of u to those of target and dependent nodes to their places, the
  /// others along with them to first order.
  void move_fixed(In<double> target, double* u);

 private:
  In<double> nodal(const double* u) const { return {u, rest_.rows, 3}; }
  void update_pattern();
  void add_terms(const double* u, TangentKind kind);
  void assemble(const double* u, TangentKind kind);
  void pull_along(const double* moved);
  void follow(const double* moved, double* step) const;
  bool factor_shifted();
  double longest_step(const double* u, const double* end);
  bool root_step(const double* u, const double* gradient, double tolerance, double* step);

  Span<const double> rest_;
  Constraint constraint_;
  std::vector<uint8_t> fixed_, bound_;  // bound: fixed, or of a dependent node
  std::vector<Term*> terms_;
  Inertia inertia_;
  std::vector<Term*> hessian_order_;  // the terms and the inertia
  std::vector<Stencils> stencils_;    // of each of these, as the pattern has them
  std::vector<double> force_, right_;
  SparseMatrix hessian_;
  LinearSolver solver_;
  LinearOptions options_;
  std::optional<NonsymmetricSolver> root_solver_;  // once find_root was called
};

}  // namespace elastogen::fem
