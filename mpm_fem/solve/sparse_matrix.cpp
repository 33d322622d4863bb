// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/sparse_matrix.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

int64_t place_of(const SparseMatrix& A, int64_t row, int64_t col) {
  const auto first = A.column.begin() + A.start[size_t(row)];
  const auto last = A.column.begin() + A.start[size_t(row) + 1];
  const auto found = std::lower_bound(first, last, int32_t(col));
  ELASTOGEN_CHECK(found != last && *found == col, "the matrix has no entry (", row, ", ", col, ")");
  return found - A.column.begin();
}

}  // namespace

double& SparseMatrix::at(int64_t row, int64_t col) {
  return value[size_t(place_of(*this, row, col))];
}

double SparseMatrix::at(int64_t row, int64_t col) const {
  return value[size_t(place_of(*this, row, col))];
}

int32_t SparseMatrix::block_place(int64_t a, int64_t b) const {
  return int32_t(place_of(*this, 3 * a, 3 * b)) - start[size_t(3 * a)];
}

void SparseMatrix::add_block(int64_t a, int64_t b, const double block[9]) {
  const int32_t place = block_place(a, b);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      value[size_t(start[size_t(3 * a + i)] + place + j)] += block[3 * i + j];
}

void multiply(const SparseMatrix& A, const double* x, double* y) {
  for_each(A.rows(), [&](int64_t r) {
    double sum = 0;
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k)
      sum += A.value[size_t(k)] * x[A.column[size_t(k)]];
    y[r] = sum;
  });
}

void add_multiple(double factor, const SparseMatrix& B, SparseMatrix& A) {
  ELASTOGEN_CHECK(A.rows() == B.rows(), "the matrices must have as many rows, got ", A.rows(),
                  " and ", B.rows());
  for_each(A.rows(), [&](int64_t r) {
    // both rows ascend
    int32_t k = A.start[size_t(r)];
    const int32_t end = A.start[size_t(r) + 1];
    for (int32_t l = B.start[size_t(r)]; l < B.start[size_t(r) + 1]; ++l) {
      const int32_t column = B.column[size_t(l)];
      while (k < end && A.column[size_t(k)] < column) ++k;
      ELASTOGEN_CHECK(k < end && A.column[size_t(k)] == column, "the matrix has no entry (", r,
                      ", ", column, ")");
      A.value[size_t(k)] += factor * B.value[size_t(l)];
    }
  });
}

std::vector<double> diagonal(const SparseMatrix& A) {
  std::vector<double> result(size_t(A.rows()));
  for_each(A.rows(), [&](int64_t r) { result[size_t(r)] = A.at(r, r); });
  return result;
}

void fix_unknowns(const uint8_t* fixed, SparseMatrix& A, double* b) {
  for_each(A.rows(), [&](int64_t r) {
    double moved = 0;
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k) {
      const int32_t c = A.column[size_t(k)];
      if (!fixed[r] && !fixed[c]) continue;
      if (!fixed[r] && b) moved += A.value[size_t(k)] * b[c];
      A.value[size_t(k)] = r == c ? 1 : 0;
    }
    if (!fixed[r] && b) b[r] -= moved;
  });
}

SparseMatrix free_part(const uint8_t* fixed, const SparseMatrix& A) {
  std::vector<int32_t> number(size_t(A.rows()));
  int32_t count = 0;
  for (int64_t r = 0; r < A.rows(); ++r) number[size_t(r)] = fixed[r] ? -1 : count++;
  SparseMatrix part;
  part.start.push_back(0);
  for (int64_t r = 0; r < A.rows(); ++r) {
    if (fixed[r]) continue;
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k) {
      const int32_t c = number[size_t(A.column[size_t(k)])];
      if (c < 0) continue;
      part.column.push_back(c);
      part.value.push_back(A.value[size_t(k)]);
    }
    part.start.push_back(int32_t(part.column.size()));
  }
  return part;
}

}  // namespace elastogen::fem
