// SPDX-License-Identifier: Apache-2.0
// Sparse Cholesky factors A = L L^T by CHOLMOD's supernodal method (Chen, Davis, Hager,
// Rajamanickam 2008).

#pragma once

#include "mpm_fem/solve/sparse_matrix.hpp"

#include <memory>

namespace elastogen::fem {

/// Returns the same bits on every run, with any number of our threads; BLAS is held at one thread.
class SparseDirect {
 public:
  /// Orders the unknowns of a pattern; the values are not read.
  /// @throws Error (resources) where the analysis does not fit into memory
  explicit SparseDirect(const SparseMatrix& pattern);
  ~SparseDirect();

  double entries() const;     ///< entries of L
  double operations() const;  ///< floating point operations of a factorisation

  /// Factors a matrix of the pattern.
  /// @return false where it is not positive definite
  /// @throws Error (resources) where L does not fit into memory
  bool factor(const SparseMatrix& A);

  /// x = A^-1 b of the matrix that was factored last; b and x may be the same.
  void solve(const double* b, double* x);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::fem
