// SPDX-License-Identifier: Apache-2.0
// Solves with matrices that share a pattern and need not be symmetric: by LU factors where they
// cost little, else by GMRES with the inverse of the 3x3 block of each node.

#pragma once

#include "core/krylov.hpp"
#include "mpm_fem/solve/linear_options.hpp"
#include "mpm_fem/solve/sparse_lu.hpp"

namespace elastogen::fem {

class NonsymmetricSolver {
 public:
  /// Without a pattern: call reset() before factor().
  explicit NonsymmetricSolver(const LinearOptions& options = {}) : options_(options) {}

  /// Sets the pattern of the matrices to come, (3 nodes, 3 nodes), and analyses it.
  void reset(const SparseMatrix& pattern);

  bool direct() const { return direct_ != nullptr; }

  /// Prepares solves with a matrix, which must stay until the last of them.
  /// @return false if it, or without LU the block of a node, is singular or not finite
  /// @throws Error unless it has the rows and entries of the pattern
  bool factor(const SparseMatrix& A);

  /// Solves A x = b, by GMRES to |b - A x| <= tolerance |b|.
  /// @return false if GMRES broke down; x is then its value before that
  bool solve(const double* b, double* x, double tolerance);

  int64_t iterations() const { return iterations_; }  ///< of GMRES, in all solves so far

 private:
  bool invert_blocks();
  void apply_blocks(const double* r, double* z) const;

  LinearOptions options_;
  std::unique_ptr<SparseLu> direct_;  // or
  std::vector<double> inverse_;       // of each node's block, (nodes, 9)
  const SparseMatrix* matrix_ = nullptr;
  GmresWork<double> work_{0};
  int64_t rows_ = -1, entries_ = -1;  // of the pattern
  int64_t iterations_ = 0;
};

}  // namespace elastogen::fem
