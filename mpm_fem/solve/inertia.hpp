// SPDX-License-Identifier: Apache-2.0
// The inertia of an implicit step as a term of a potential,
//
//     E(u) = a/2 (u - uhat).M (u - uhat).

#pragma once

#include "mpm_fem/solve/mass_matrix.hpp"
#include "mpm_fem/solve/term.hpp"

namespace elastogen::fem {

class Inertia final : public Term {
 public:
  /// a = 0: no inertia before set().
  explicit Inertia(MassMatrix mass);

  const MassMatrix& mass() const { return mass_; }
  void set(double weight, In<double> predictor);  ///< a [1/s^2], uhat [m], (nodes, 3)

  /// a (u - uhat) [m/s^2], (nodes, 3).
  void find_accelerations(In<double> u, double* acceleration) const;

  const Stencils& stencils() const override { return mass_.stencils(); }
  TermValue value(In<double> u) override;
  void add_gradient(In<double> u, Out<double> g) override;
  void add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) override;

 private:
  void find_away(In<double> u);

  MassMatrix mass_;
  double weight_ = 0;
  std::vector<double> predictor_, away_, mass_away_;  // uhat, u - uhat, M (u - uhat)
};

}  // namespace elastogen::fem
