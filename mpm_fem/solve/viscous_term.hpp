// SPDX-License-Identifier: Apache-2.0
// The damping of a mesh as a term of a potential.

#pragma once

#include "mpm_fem/fem/viscous_body.hpp"
#include "mpm_fem/solve/assembly.hpp"
#include "mpm_fem/solve/term.hpp"

namespace elastogen::fem {

/// D of ViscousBody, with a bound on its rounding error as that of ElasticTerm, from
/// S = sum_e V_e beta (2 mu + lambda).
class ViscousTerm final : public Term {
 public:
  /// @throws Error as ViscousBody
  ViscousTerm(const ElementMesh& mesh, std::vector<Material> materials);

  ViscousBody& body() { return body_; }
  const ViscousBody& body() const { return body_; }

  const Stencils& stencils() const override { return assembly_.stencils(); }
  void take_pattern(const SparseMatrix& pattern) override { assembly_.fit(pattern); }
  TermValue value(In<double> u) override;
  void add_gradient(In<double> u, Out<double> g) override { body_.add_gradient(u, g); }
  void add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) override;

 private:
  ViscousBody body_;
  Assembly assembly_;
  double edge_;  // mean one of an element [m]
};

}  // namespace elastogen::fem
