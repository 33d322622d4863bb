// SPDX-License-Identifier: Apache-2.0
// The mass of all nodes, lumped or consistent.

#pragma once

#include "mpm_fem/fem/elastic_body.hpp"
#include "mpm_fem/fem_scene.hpp"
#include "mpm_fem/solve/stencils.hpp"

namespace elastogen::fem {

class MassMatrix {
 public:
  /// @throws Error if scene.mass is not one positive number for each node, or is given with a
  ///         consistent mass.
  MassMatrix(const FemScene& scene, const ElasticBody& body);
  /// A lumped mass.
  /// @param nodal  of each node [kg], (nodes, 1)
  /// @throws Error where one is not positive
  explicit MassMatrix(Array<double> nodal);

  /// Mass of each node [kg], (nodes, 1): with a consistent matrix that of ElasticBody::lumped_mass.
  const Array<double>& nodal() const { return nodal_; }
  bool consistent() const { return matrix_.rows() > 0; }
  /// Nodes that the matrix couples; none if it is lumped.
  const Stencils& stencils() const { return stencils_; }

  /// y = M x, nodal vectors (nodes, 3).
  void multiply(const double* x, double* y) const;
  /// A += a M. @throws Error where A lacks an entry
  void add_to(double a, SparseMatrix& A) const;

 private:
  Array<double> nodal_;
  Stencils stencils_;
  SparseMatrix matrix_;  // empty: lumped
};

}  // namespace elastogen::fem
