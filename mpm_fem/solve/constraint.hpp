// SPDX-License-Identifier: Apache-2.0
// Dependent nodes (core/dependent_nodes.hpp) in a system of all nodes:
//
//     u = C y + c,     u_i = sum_m w_im u_m + c_i at dependent nodes i, u = y at the others,
//
// so that a function of u has the gradient C^T g and the Hessian C^T H C in y. The system keeps the
// rows of dependent nodes; their part of the others is folded, they themselves get 0.

#pragma once

#include "core/dependent_nodes.hpp"
#include "mpm_fem/solve/stencils.hpp"

namespace elastogen::fem {

class Constraint {
 public:
  Constraint() = default;  ///< no node is dependent
  explicit Constraint(DependentNodes dependent);

  bool empty() const { return dependent_.empty(); }
  const DependentNodes& dependent() const { return dependent_; }
  /// Sets c [m], (dependent nodes, 3), which is 0 before.
  /// @throws Error on another shape
  void set_offset(In<double> offset);
  bool has_offset() const { return !offset_.empty(); }

  void place(double* u) const;                                      ///< u_i = sum w u_m + c_i
  void follow(double* change) const { dependent_.fill(change); }    ///< without c
  void fold(double* gradient) const { dependent_.fold(gradient); }  ///< g = C^T g
  /// H = C^T H C, whose pattern has all stencils of widened().
  void fold(SparseMatrix& H) const;
  /// Stencils with the parent nodes of their dependent nodes.
  Stencils widened(const Stencils& stencils) const;
  /// Sets the unknowns of dependent nodes to 1.
  void mark(std::vector<uint8_t>& unknowns) const;

 private:
  /// Calls use(parent node, weight) for the parent nodes of dependent node i.
  template <class Use>
  void for_parents(int64_t i, const Use& use) const;

  DependentNodes dependent_;
  Array<double> offset_;        // empty: 0
  std::vector<int32_t> place_;  // of a node among the dependent ones, -1: it is none
};

}  // namespace elastogen::fem
