// SPDX-License-Identifier: Apache-2.0
// Inverses of the dense operators of the coarsest level by the sweep operator, one column K of
// tiles after the other. Three kernels make a step: pivot_kernel inverts A_KK, panel_kernel
// multiplies the tiles of the column with the inverse, and update_kernel changes all other tiles.
// Only tiles on and below the diagonal are stored; at the end they hold -A^-1.
#include "core/cuda/inverse.cuh"
#include "network/precondition/dense.cuh"

namespace elastogen::cuda {
namespace {

constexpr int kTile = kDenseTile, kBlock = kTile * kTile;
constexpr int kSide = 16, kOf = kTile / kSide;  // per axis: threads of a block, entries of a thread
constexpr int kChunk = kSide;                   // columns that are in shared memory at a time
using Pivot = InverseTile<kOf>;
static_assert(Pivot::kWidth == kSide && Pivot::kRows == kTile);

/// The matrices, of which only tiles on and below the diagonal are used, and for the column K of
/// tiles that is swept: A_KK^-1, (3, kTile, kTile), the column A_K before the step, and
/// A_K A_KK^-1, (3, size, kTile) each.
struct Sweep {
  double *matrix, *inverse, *before, *after;
  int64_t size;
  int k;

  __device__ double* entry(int matrix_of, int64_t i, int64_t j) const {
    return matrix + (matrix_of * size + i) * size + j;
  }
  __device__ double* rows(double* of, int matrix_of, int tile) const {
    return of + (matrix_of * size + int64_t(kTile) * tile) * kTile;
  }
};

/// sum += X Y^T for two tiles with rows of kTile numbers. Thread (x, y) has the products of rows
/// y + kSide a of X and x + kSide b of Y. The block copies kChunk columns of both tiles at a time
/// into shared memory, transposed; rows there are one number longer, against bank conflicts.
__device__ void add_product(const double* X, const double* Y, double sum[kOf][kOf]) {
  __shared__ double of_x[kChunk][kTile + 1], of_y[kChunk][kTile + 1];
  const int x = int(threadIdx.x), y = int(threadIdx.y);
  for (int first = 0; first < kTile; first += kChunk) {
    __syncthreads();
#pragma unroll
    for (int a = 0; a < kOf; ++a) {
      const int row = y + kSide * a;
      of_x[x][row] = X[row * kTile + first + x];
      of_y[x][row] = Y[row * kTile + first + x];
    }
    __syncthreads();
#pragma unroll
    for (int c = 0; c < kChunk; ++c)
#pragma unroll
      for (int a = 0; a < kOf; ++a)
#pragma unroll
        for (int b = 0; b < kOf; ++b) sum[a][b] += of_x[c][y + kSide * a] * of_y[c][x + kSide * b];
  }
}

/// Puts A_KK^-1 into `inverse`, and its negative in the place of A_KK. One block for each matrix,
/// which holds the tile in registers (InverseTile).
__global__ void __launch_bounds__(Pivot::kThreads) pivot_kernel(Sweep s) {
  __shared__ Pivot::Scratch scratch;
  begin_kernel();
  const int m = int(blockIdx.x), first = kTile * s.k;
  double* const inverse = s.inverse + m * kBlock;
  Pivot tile(kTile,
             [&](int i, int j) { return *s.entry(m, first + max(i, j), first + min(i, j)); });
  tile.invert(scratch);
  tile.for_entries([&](int i, int j, double value) {
    inverse[i * kTile + j] = value;
    *s.entry(m, first + i, first + j) = -value;
  });
}

/// A_IK becomes A_IK A_KK^-1. Grid (tiles I, matrices). A block first copies A_IK to `before`,
/// which update_kernel needs too, then multiplies it and writes the product to `after` and into the
/// matrix. Tiles above the diagonal are the transposes of those stored below it.
__global__ void __launch_bounds__(Pivot::kThreads) panel_kernel(Sweep s) {
  begin_kernel();
  const int tile = int(blockIdx.x), m = int(blockIdx.y);
  if (tile == s.k) return;
  const int x = int(threadIdx.x), y = int(threadIdx.y);
  double *const before = s.rows(s.before, m, tile), *const after = s.rows(s.after, m, tile);
  // entry (i, j) of A_IK in the matrix; where I < K its transpose is stored
  const auto place = [&](int i, int j) {
    const int64_t row = int64_t(kTile) * tile + i, column = int64_t(kTile) * s.k + j;
    return tile > s.k ? s.entry(m, row, column) : s.entry(m, column, row);
  };
  for (int a = 0; a < kOf; ++a)
    for (int b = 0; b < kOf; ++b) {  // threads of a warp along the rows of the matrix
      const int p = y + kSide * a, q = x + kSide * b, i = tile > s.k ? p : q, j = p + q - i;
      before[i * kTile + j] = *place(i, j);
    }
  __syncthreads();
  // A_IK A_KK^-1, as the inverse is symmetric
  double sum[kOf][kOf] = {};
  add_product(before, s.inverse + m * kBlock, sum);
  for (int a = 0; a < kOf; ++a)
    for (int b = 0; b < kOf; ++b) {
      const int i = y + kSide * a, j = x + kSide * b;
      after[i * kTile + j] = sum[a][b];
      *place(i, j) = sum[a][b];
    }
}

/// A_IJ -= A_IK A_KK^-1 A_KJ for I >= J, neither of them K. Grid (pairs of tiles, matrices).
__global__ void __launch_bounds__(Pivot::kThreads) update_kernel(Sweep s) {
  begin_kernel();
  int row, column;
  find_tile(int(blockIdx.x), row, column);
  const int m = int(blockIdx.y);
  if (row == s.k || column == s.k) return;
  double sum[kOf][kOf] = {};
  add_product(s.rows(s.after, m, row), s.rows(s.before, m, column), sum);
  for (int a = 0; a < kOf; ++a)
    for (int b = 0; b < kOf; ++b)
      *s.entry(m, int64_t(kTile) * row + int(threadIdx.y) + kSide * a,
               int64_t(kTile) * column + int(threadIdx.x) + kSide * b) -= sum[a][b];
}

/// Sweeps all columns, which leaves -A^-1 on and below the diagonals of A, (3, size, size).
void sweep(DeviceArray<double>& A, int64_t size) {
  const auto tiles = unsigned(size / kTile);
  DeviceArray<double> inverse(kDenseMatrices * kBlock), before(kDenseMatrices * size * kTile),
      after(before.size());
  Sweep s{A.data(), inverse.data(), before.data(), after.data(), size, 0};
  constexpr dim3 kThreads(kSide, kSide);
  for (; s.k < int(tiles); ++s.k) {
    launch(pivot_kernel, kDenseMatrices, kThreads, 0, s);
    launch(panel_kernel, dim3(tiles, kDenseMatrices), kThreads, 0, s);
    launch(update_kernel, dim3(unsigned(tile_pairs(tiles)), kDenseMatrices), kThreads, 0, s);
  }
  synchronise();
}

/// Entry (i, j) of inverse m of the swept matrices.
__device__ double inverse_entry(const double* swept, int64_t size, int64_t m, int64_t i,
                                int64_t j) {
  return -swept[(m * size + max(i, j)) * size + min(i, j)];
}

/// Whether memory is only counted. The count then loses the operators, which are freed here.
bool counts_only(const DeviceArray<double>& operators) {
  MemoryCount* const count = MemoryCount::present();
  if (count) count->take_off(size_t(operators.size()) * sizeof(double));
  return count != nullptr;
}

}  // namespace

template <class T>
DeviceArray<T> dense_inverses(DeviceArray<double> operators, int64_t n) {
  const int64_t size = dense_pitch(n);
  DeviceArray<T> inverses(kDenseMatrices * n * size);
  if (counts_only(operators)) return inverses;
  sweep(operators, size);
  const double* const swept = operators.data();
  T* const to = inverses.data();
  cuda::for_each(inverses.size(), [=] __device__(int64_t k) {
    const int64_t j = k % size, i = k / size % n, m = k / size / n;
    if (j < n) to[k] = T(inverse_entry(swept, size, m, i, j));
  });
  synchronise();
  return inverses;
}

template <class T>
DeviceArray<T> dense_inverse_tiles(DeviceArray<double> operators, int64_t n) {
  const int64_t size = dense_pitch(n), pairs = tile_pairs(size / kTile);
  DeviceArray<T> tiles(kDenseMatrices * pairs * kBlock);
  if (counts_only(operators)) return tiles;
  sweep(operators, size);
  const double* const swept = operators.data();
  T* const to = tiles.data();
  cuda::for_each(tiles.size(), [=] __device__(int64_t k) {
    const int j = int(k % kTile), i = int(k / kTile % kTile), m = int(k / (kBlock * pairs));
    int I, J;
    find_tile(int(k / kBlock % pairs), I, J);
    const int64_t row = int64_t(kTile) * I + i, column = int64_t(kTile) * J + j;
    if (row < n && column < n) to[k] = T(inverse_entry(swept, size, m, row, column));
  });
  synchronise();
  return tiles;
}

template DeviceArray<float> dense_inverses(DeviceArray<double>, int64_t);
template DeviceArray<double> dense_inverses(DeviceArray<double>, int64_t);
template DeviceArray<float> dense_inverse_tiles(DeviceArray<double>, int64_t);
template DeviceArray<double> dense_inverse_tiles(DeviceArray<double>, int64_t);

}  // namespace elastogen::cuda
