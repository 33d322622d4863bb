// SPDX-License-Identifier: Apache-2.0
// Symmetric sparse matrices of three components a node, in compressed rows with both triangles, and
// their assembly from element matrices.

#pragma once

#include "core/array.hpp"

#include <functional>
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
};

/// y = A x, vectors of A.rows().
void multiply(const SparseMatrix& A, const double* x, double* y);

/// Diagonal of A, (rows).
std::vector<double> diagonal(const SparseMatrix& A);

/// Makes the rows and columns of the fixed unknowns those of the identity.
/// @param fixed  1 where an unknown is fixed, A.rows() of them
/// @param b      right-hand side or null. In: what the fixed unknowns shall be, and the right-hand
///               sides of the others. Out: from the latter, A times the former is taken off.
void fix_unknowns(const uint8_t* fixed, SparseMatrix& A, double* b);

/// A without the rows and columns of the fixed unknowns.
SparseMatrix free_part(const uint8_t* fixed, const SparseMatrix& A);

/// Writes the symmetric matrix of an element, row-major (3 n, 3 n), dof 3 corner + component.
using ElementMatrix = std::function<void(int64_t element, double* K)>;

/// Sums element matrices. The pattern is made once; elements are added colour by colour, where no
/// two of a colour share a node, so that the result does not depend on the number of threads.
class Assembly {
 public:
  /// @param elements  nodes of each element, (elements, n)
  /// @throws Error where a matrix of these nodes has too many entries for 32 bits
  Assembly(In<int32_t> elements, int64_t nodes);

  /// Zero matrix of the pattern, (3 nodes, 3 nodes).
  const SparseMatrix& pattern() const { return pattern_; }

  /// A += the element matrices. A must have the pattern.
  void add(const ElementMatrix& element_matrix, SparseMatrix& A) const;

 private:
  void make_pattern(In<int32_t> elements, int64_t nodes);
  void make_colours(In<int32_t> elements, int64_t nodes);

  SparseMatrix pattern_;
  int corners_ = 0;
  std::vector<int32_t> nodes_;      // of the elements, (elements, corners)
  std::vector<int32_t> place_;      // of corner b's columns in a row of a, (elements, corners^2)
  std::vector<int32_t> by_colour_;  // elements in the order of their colours
  std::vector<int64_t> colours_;    // first element of each in by_colour_, and the end
};

}  // namespace elastogen::fem
