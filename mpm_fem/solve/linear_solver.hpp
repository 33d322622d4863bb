// SPDX-License-Identifier: Apache-2.0
// Solves with symmetric matrices that share a pattern: by Cholesky factors where they cost little,
// else by conjugate gradients. Their preconditioner is the inverse of the 3x3 block of each node
// plus a coarse space of rigid motions: about a hundred iterations for any number of nodes (1.4e5
// nodes of tet10, nu = 0.3: 106 to 1e-6), more towards nu = 0.5.

#pragma once

#include "core/pcg.hpp"
#include "mpm_fem/solve/coarse_space.hpp"
#include "mpm_fem/solve/linear_options.hpp"

namespace elastogen::fem {

class LinearSolver {
 public:
  /// @param pattern    of the matrices, (3 nodes, 3 nodes)
  /// @param positions  of the nodes [m], (nodes, 3)
  /// @param fixed      1 where the rows of the matrices are those of the identity, (3 nodes)
  LinearSolver(const SparseMatrix& pattern, In<double> positions, const uint8_t* fixed,
               const LinearOptions& options = {});
  /// Without a pattern: call reset() before factor().
  explicit LinearSolver(const LinearOptions& options = {}) : options_(options) {}

  /// Sets another pattern, and analyses it.
  void reset(const SparseMatrix& pattern, In<double> positions, const uint8_t* fixed);

  bool direct() const { return direct_ != nullptr; }

  /// Prepares solves with a matrix, which must stay until the last of them.
  /// @return false if it turns out not to be positive definite
  /// @throws Error unless it has the rows and entries of the pattern
  bool factor(const SparseMatrix& A);

  /// Solves A x = b, by PCG to |b - A x| <= tolerance |b|.
  /// @return false if PCG met a direction of negative curvature; x is then its value before that
  bool solve(const double* b, double* x, double tolerance);

  int64_t iterations() const { return iterations_; }  ///< of PCG, in all solves so far
  int analyses() const { return analyses_; }          ///< of patterns so far

 private:
  bool invert_blocks();

  LinearOptions options_;
  std::unique_ptr<SparseDirect> direct_;  // or
  std::unique_ptr<CoarseSpace> coarse_;
  std::vector<double> inverse_;  // of each node's block, (nodes, 9)
  const SparseMatrix* matrix_ = nullptr;
  PcgWork<double> work_{0};
  int64_t iterations_ = 0;
  int64_t rows_ = -1, entries_ = -1;  // of the pattern
  int analyses_ = 0;
};

}  // namespace elastogen::fem
