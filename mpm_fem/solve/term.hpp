// SPDX-License-Identifier: Apache-2.0
// What a potential is made of: elements of a mesh, inertia, contact, later particles and pairs. All
// terms see one vector of unknowns, the displacements of all nodes.

#pragma once

#include "core/tangent.hpp"
#include "mpm_fem/solve/stencils.hpp"

namespace elastogen::fem {

struct TermValue {
  double value = 0;     ///< E(u) [J]
  double size = 0;      ///< sum of the magnitudes that it was added up from [J]
  double rounding = 0;  ///< its rounding error beyond that of the sum, in eps [J]
};

/// A function E of the displacements u [m], (nodes, 3), of all nodes.
class Term {
 public:
  virtual ~Term() = default;

  /// The nodes that have a block of the Hessian in common. They may differ from call to call of
  /// add_hessian, at which no others have one.
  virtual const Stencils& stencils() const = 0;
  /// Sees the pattern of the matrices that add_hessian is given from now on.
  virtual void take_pattern(const SparseMatrix&) {}

  /// E(u); infinite where u is out of reach.
  virtual TermValue value(In<double> u) = 0;
  /// Adds dE/du [N] to g, (nodes, 3).
  virtual void add_gradient(In<double> u, Out<double> g) = 0;
  /// Adds d2E/du2 [N/m] to H; kProjected: with the negative curvature that can be told left out.
  virtual void add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) = 0;

  /// Largest share, at most 1, of the way from u to `end` on which E stays finite.
  virtual double longest_step(In<double> /*u*/, In<double> /*end*/) { return 1; }
  /// Length [m] by whose eps positions are rounded within the term; 0: only u is.
  virtual double length() const { return 0; }
};

}  // namespace elastogen::fem
