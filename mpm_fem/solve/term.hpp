// SPDX-License-Identifier: Apache-2.0
// The terms of a potential: elements of a mesh, inertia, contact. All terms have one vector of
// unknowns, the displacements of all nodes.

#pragma once

#include "core/tangent.hpp"
#include "mpm_fem/solve/stencils.hpp"

namespace elastogen::fem {

struct TermValue {
  double value = 0;     ///< E(u) [J]
  double size = 0;      ///< sum of the magnitudes of its summands [J]
  double rounding = 0;  ///< its rounding error beyond that of the sum, in eps [J]
};

/// A function E of the displacements u [m], (nodes, 3), of all nodes.
class Term {
 public:
  virtual ~Term() = default;

  /// The nodes that have a block of the Hessian in common. They may change between calls of
  /// add_hessian, which adds no other blocks.
  virtual const Stencils& stencils() const = 0;
  /// Gets the pattern of the matrices that add_hessian gets from now on.
  virtual void take_pattern(const SparseMatrix&) {}

  /// E(u); infinite where u is not admissible.
  virtual TermValue value(In<double> u) = 0;
  /// Adds dE/du [N] to g, (nodes, 3).
  virtual void add_gradient(In<double> u, Out<double> g) = 0;
  /// Adds d2E/du2 [N/m] to H; kProjected: without the negative curvature that the term can
  /// identify.
  virtual void add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) = 0;

  /// Largest share, at most 1, of the path from u to `end` on which E stays finite.
  virtual double longest_step(In<double> /*u*/, In<double> /*end*/) { return 1; }
  /// Length [m] by whose eps positions within the term are rounded; 0: only u is rounded.
  virtual double length() const { return 0; }
};

}  // namespace elastogen::fem
