// SPDX-License-Identifier: Apache-2.0
// Inverses of small dense matrices, each by a block of threads that hold its entries in registers.

#pragma once

#include "core/cuda/launch.cuh"

namespace elastogen::cuda {

/// The entries of one thread in a matrix of at most kRows rows, and the inverse of the matrix. A
/// block has kWidth x kWidth threads; thread (x, y) holds entries (y + kWidth a, x + kWidth b).
template <int kSpan>
class InverseTile {
 public:
  static constexpr int kWidth = 16, kThreads = kWidth * kWidth;
  static constexpr int kRows = kSpan * kWidth;  ///< at most

  /// Row and column of a step in shared memory; two buffers take turns, so a step needs one
  /// barrier.
  struct Scratch {
    double row[2][kRows], column[2][kRows];
  };

  /// A(i, j) = value(i, j); the identity beyond n.
  template <class Value>
  __device__ InverseTile(int n, const Value& value) : rows_(n) {
    for_entries(
        [&](int i, int j, double& a) { a = i < n && j < n ? value(i, j) : double(i == j); });
  }

  /// Calls body(i, j, A(i, j)) for the entries of this thread.
  template <class Body>
  __device__ void for_entries(const Body& body) {
#pragma unroll
    for (int a = 0; a < kSpan; ++a)
#pragma unroll
      for (int b = 0; b < kSpan; ++b)
        body(int(threadIdx.y) + kWidth * a, int(threadIdx.x) + kWidth * b, entry_[a][b]);
  }

  /// Calls body(i, j, A(i, j), B(i, j)) for the entries of this thread.
  template <class Body>
  __device__ void for_entries(InverseTile& B, const Body& body) {
#pragma unroll
    for (int a = 0; a < kSpan; ++a)
#pragma unroll
      for (int b = 0; b < kSpan; ++b)
        body(int(threadIdx.y) + kWidth * a, int(threadIdx.x) + kWidth * b, entry_[a][b],
             B.entry_[a][b]);
  }

  /// A becomes its inverse, A symmetric and positive definite: Gauss-Jordan without pivoting, one
  /// row and column after the other. All threads of the block must call it.
  __device__ void invert(Scratch& scratch) {
#pragma unroll
    for (int block = 0; block < kSpan; ++block)
      for (int k = 0; k < kWidth && kWidth * block + k < rows_; ++k) eliminate(block, k, scratch);
  }

 private:
  /// Eliminates row and column number kWidth block + k. With -1 and 1 in place of the pivot, and 0
  /// in place of row and column, all entries change alike, A -= column row / pivot. The products
  /// come before the quotient, so that the result is symmetric to the bit.
  __device__ void eliminate(int block, int k, Scratch& scratch) {
    double *const row = scratch.row[k % 2], *const column = scratch.column[k % 2];
    const int x = int(threadIdx.x), y = int(threadIdx.y), at = kWidth * block + k;
    // the threads that hold them put row and column into shared memory
#pragma unroll
    for (int b = 0; b < kSpan; ++b) {
      if (y == k) row[x + kWidth * b] = entry_[block][b];
      if (x == k) column[y + kWidth * b] = entry_[b][block];
    }
    __syncthreads();
    const double inverse = 1 / row[at];
    // in the matrix they become 0
#pragma unroll
    for (int b = 0; b < kSpan; ++b) {
      if (y == k) entry_[block][b] = 0;
      if (x == k) entry_[b][block] = 0;
    }
    // the products, for the entries of this thread
#pragma unroll
    for (int b = 0; b < kSpan; ++b) {
      const int j = x + kWidth * b;
      const double r = j == at ? 1 : row[j];
#pragma unroll
      for (int a = 0; a < kSpan; ++a) {
        const int i = y + kWidth * a;
        entry_[a][b] -= (i == at ? -1 : column[i]) * r * inverse;
      }
    }
  }

  int rows_;
  double entry_[kSpan][kSpan];
};

}  // namespace elastogen::cuda
