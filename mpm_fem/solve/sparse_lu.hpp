// SPDX-License-Identifier: Apache-2.0
// Sparse factors P A Q = L U of matrices that need not be symmetric, by UMFPACK's multifrontal
// method (Davis 2004).

#pragma once

#include "mpm_fem/solve/sparse_matrix.hpp"

#include <memory>

namespace elastogen::fem {

/// Returns the same bits on every run, with any number of our threads; BLAS is held at one thread.
class SparseLu {
 public:
  /// Orders the unknowns of a pattern; the values are not read.
  /// @throws Error (resources) where the analysis does not fit into memory
  explicit SparseLu(const SparseMatrix& pattern);
  ~SparseLu();

  double operations() const;  ///< floating point operations of a factorisation, an upper bound

  /// Factors a matrix of the pattern, which must stay until the last solve.
  /// @return false where it is singular or not finite
  /// @throws Error (resources) where L and U do not fit into memory
  bool factor(const SparseMatrix& A);

  /// x = A^-1 b of the matrix that was factored last; b and x may not be the same.
  /// @throws Error where none was
  void solve(const double* b, double* x);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::fem
