// SPDX-License-Identifier: Apache-2.0
// The elements of one mesh as a term of a potential.

#pragma once

#include "mpm_fem/fem/elastic_body.hpp"
#include "mpm_fem/solve/assembly.hpp"
#include "mpm_fem/solve/term.hpp"

namespace elastogen::fem {

/// E of ElasticBody, with the bound on its rounding error
///
///     4 sqrt(2 S E) (1 + |u|/l),  S = sum_e V_e (2 mu + lambda):
///
/// stretches are rounded by eps (1 + |u|/l), l the mean edge of an element.
class ElasticTerm final : public Term {
 public:
  /// @param first_node  number of the mesh's node 0 among the nodes of the potential
  /// @throws Error as ElasticBody
  ElasticTerm(const ElementMesh& mesh, std::vector<Material> materials, int32_t first_node = 0);

  ElasticBody& body() { return body_; }
  const ElasticBody& body() const { return body_; }

  const Stencils& stencils() const override { return assembly_.stencils(); }
  void take_pattern(const SparseMatrix& pattern) override { assembly_.fit(pattern); }
  TermValue value(In<double> u) override;
  void add_gradient(In<double> u, Out<double> g) override;
  void add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) override;
  double length() const override { return edge_; }  ///< l

 private:
  template <class T>
  Span<T> own(Span<T> nodal) const;

  ElasticBody body_;
  int64_t first_node_;
  Assembly assembly_;
  double edge_ = 0;       // l [m]
  double stiffness_ = 0;  // S [J]
};

}  // namespace elastogen::fem
