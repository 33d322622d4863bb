// SPDX-License-Identifier: Apache-2.0
// Elements that yield as a term of a potential, with the bound on rounding of ElasticTerm.

#pragma once

#include "mpm_fem/fem/plastic_body.hpp"
#include "mpm_fem/solve/assembly.hpp"
#include "mpm_fem/solve/term.hpp"

namespace elastogen::fem {

/// For laws without potential, until the body is frozen, the gradient is the true force and the
/// Hessian its derivative, which is not symmetric. Steps end where det F would fall below a tenth.
class PlasticTerm final : public Term {
 public:
  /// @throws Error as PlasticBody
  PlasticTerm(const ElementMesh& mesh, const std::vector<Solid>& solids);

  PlasticBody& body() { return body_; }
  const PlasticBody& body() const { return body_; }

  const Stencils& stencils() const override { return assembly_.stencils(); }
  void take_pattern(const SparseMatrix& pattern) override { assembly_.fit(pattern); }
  TermValue value(In<double> u) override;
  void add_gradient(In<double> u, Out<double> g) override { body_.add_gradient(u, g); }
  void add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) override;
  double longest_step(In<double> u, In<double> end) override { return body_.longest_step(u, end); }
  double length() const override { return edge_; }  ///< mean edge of an element [m]

 private:
  PlasticBody body_;
  Assembly assembly_;
  double edge_ = 0;       // [m]
  double stiffness_ = 0;  // sum_e V_e (2 mu + lambda) [J]
};

}  // namespace elastogen::fem
