// SPDX-License-Identifier: Apache-2.0
// Sparse matrices with three components for each node, in compressed rows. Symmetric ones store
// both triangles.

#pragma once

#include <cstdint>
#include <vector>

namespace elastogen::fem {

/// Row r has the columns column[start[r] .. start[r+1]), ascending.
struct SparseMatrix {
  std::vector<int32_t> start;   ///< (rows + 1)
  std::vector<int32_t> column;  ///< (entries)
  std::vector<double> value;    ///< (entries)

  int64_t rows() const { return int64_t(start.size()) - 1; }
  int64_t entries() const { return int64_t(column.size()); }
  /// Entry of a row and column. @throws Error where the pattern has none.
  double& at(int64_t row, int64_t col);
  double at(int64_t row, int64_t col) const;
  /// Where the columns of node b begin in each row of node a. @throws Error as at
  int32_t block_place(int64_t a, int64_t b) const;
  /// Adds a 3x3 block, row-major, to the rows of node a and the columns of node b.
  /// @throws Error as at
  void add_block(int64_t a, int64_t b, const double block[9]);
};

/// y = A x, vectors of A.rows().
void multiply(const SparseMatrix& A, const double* x, double* y);

/// A += factor B. @throws Error where B has an entry that A has not
void add_multiple(double factor, const SparseMatrix& B, SparseMatrix& A);

/// Diagonal of A, (rows).
std::vector<double> diagonal(const SparseMatrix& A);

/// Makes the rows and columns of the fixed unknowns those of the identity.
/// @param fixed  1 where an unknown is fixed, A.rows() of them
/// @param b      right-hand side or null. In: the values of the fixed unknowns, and the right-hand
///               sides of the others. Out: the latter less A times the former.
void fix_unknowns(const uint8_t* fixed, SparseMatrix& A, double* b);

/// A without the rows and columns of the fixed unknowns.
SparseMatrix free_part(const uint8_t* fixed, const SparseMatrix& A);

}  // namespace elastogen::fem
