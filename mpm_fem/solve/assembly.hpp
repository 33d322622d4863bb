// SPDX-License-Identifier: Apache-2.0
// Sums the small matrices of stencils into a sparse one.

#pragma once

#include "mpm_fem/solve/stencils.hpp"

#include <functional>

namespace elastogen::fem {

/// Writes the matrix of a stencil of n nodes, row-major (3 n, 3 n), dof 3 a + component of its node
/// a. It need not be symmetric.
using StencilMatrix = std::function<void(int64_t stencil, double* K)>;

/// Stencils are added colour by colour. No two of a colour share a node, so that the result does
/// not depend on the number of threads. The colours are made once, the places in the matrix anew
/// with each pattern.
class Assembly {
 public:
  /// @throws Error as stencils_of_nodes
  Assembly(Stencils stencils, int64_t nodes);

  const Stencils& stencils() const { return stencils_; }

  /// Finds the places of the stencils in a pattern, which may have more entries than they need.
  /// @throws Error where it has fewer
  void fit(const SparseMatrix& pattern);

  /// A += the matrices of all stencils. A must have the pattern that was fitted last.
  void add(const StencilMatrix& stencil_matrix, SparseMatrix& A) const;

 private:
  void make_colours(int64_t nodes);
  void add_one(int64_t stencil, const double* K, SparseMatrix& A) const;

  Stencils stencils_;
  int64_t longest_ = 0;               // nodes of the longest stencil
  std::vector<int64_t> square_;       // where the places of each stencil begin, and the end
  std::vector<int32_t> place_;        // of node b's columns in a row of node a, for all (a, b)
  std::vector<int32_t> by_colour_;    // stencils in the order of their colours
  std::vector<int64_t> colours_;      // first stencil of each in by_colour_, and the end
  int64_t rows_ = -1, entries_ = -1;  // of the pattern
};

}  // namespace elastogen::fem
