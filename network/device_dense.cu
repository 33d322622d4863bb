// SPDX-License-Identifier: Apache-2.0
#include "core/device_inverse.cuh"
#include "network/device_dense.cuh"

namespace elastogen::cuda {
namespace {

constexpr int kTile = kDenseTile, kBlock = kTile * kTile;
constexpr int kSide = 16, kOf = kTile / kSide;  // per axis: threads of a block, entries of a thread
constexpr int kChunk = kSide;                   // columns that are in shared memory at a time
using Pivot = InverseTile<kOf>;
static_assert(Pivot::kWidth == kSide && Pivot::kRows == kTile);

constexpr int kMatrices = 3;

/// Matrices that are swept, of which tiles on and below the diagonal count, and for the tile K of
/// columns that is swept: A_KK^-1, (3, kTile, kTile), the columns A_K before that, and A_K A_KK^-1,
/// (3, size, kTile) each.
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

/// Tiles on and below the diagonal, row by row, and which the one of a number is.
ELASTOGEN_HD inline int64_t pairs_of(int64_t tiles) {
  return tiles * (tiles + 1) / 2;
}
__device__ void find_tile(int pair, int& I, int& J) {
  I = int((sqrtf(8 * float(pair) + 1) - 1) / 2);
  while (pairs_of(I + 1) <= pair) ++I;
  while (pairs_of(I) > pair) --I;
  J = pair - int(pairs_of(I));
}

/// sum += X Y^T for two tiles with rows of kTile numbers; of thread (x, y) rows y + kSide a of X
/// and x + kSide b of Y.
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

/// A_KK^-1, and its negative in the place of A_KK. A block a matrix.
__global__ void __launch_bounds__(Pivot::kThreads) pivot_kernel(Sweep s) {
  __shared__ Pivot::Room room;
  begin_kernel();
  const int m = int(blockIdx.x), first = kTile * s.k;
  double* const inverse = s.inverse + m * kBlock;
  Pivot tile(kTile,
             [&](int i, int j) { return *s.entry(m, first + max(i, j), first + min(i, j)); });
  tile.invert(room);
  tile.for_entries([&](int i, int j, double value) {
    inverse[i * kTile + j] = value;
    *s.entry(m, first + i, first + j) = -value;
  });
}

/// A_IK becomes A_IK A_KK^-1. Blocks (tiles I, matrices).
__global__ void __launch_bounds__(Pivot::kThreads) panel_kernel(Sweep s) {
  begin_kernel();
  const int tile = int(blockIdx.x), m = int(blockIdx.y);
  if (tile == s.k) return;
  const int x = int(threadIdx.x), y = int(threadIdx.y);
  double *const before = s.rows(s.before, m, tile), *const after = s.rows(s.after, m, tile);
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
  double sum[kOf][kOf] = {};
  add_product(before, s.inverse + m * kBlock, sum);
  for (int a = 0; a < kOf; ++a)
    for (int b = 0; b < kOf; ++b) {
      const int i = y + kSide * a, j = x + kSide * b;
      after[i * kTile + j] = sum[a][b];
      *place(i, j) = sum[a][b];
    }
}

/// A_IJ -= A_IK A_KK^-1 A_KJ for I >= J, neither of them K. Blocks (pairs of tiles, matrices).
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

/// Leaves -A^-1 on and below the diagonals of A, (3, size, size).
void sweep(DeviceArray<double>& A, int64_t size) {
  const auto tiles = unsigned(size / kTile);
  DeviceArray<double> inverse(kMatrices * kBlock), before(kMatrices * size * kTile),
      after(before.size());
  Sweep s{A.data(), inverse.data(), before.data(), after.data(), size, 0};
  constexpr dim3 kThreads(kSide, kSide);
  for (; s.k < int(tiles); ++s.k) {
    launch(pivot_kernel, kMatrices, kThreads, 0, s);
    launch(panel_kernel, dim3(tiles, kMatrices), kThreads, 0, s);
    launch(update_kernel, dim3(unsigned(pairs_of(tiles)), kMatrices), kThreads, 0, s);
  }
  synchronise();
}

/// Entry of the inverse m of swept matrices.
__device__ double inverse_entry(const double* swept, int64_t size, int64_t m, int64_t i,
                                int64_t j) {
  return -swept[(m * size + max(i, j)) * size + min(i, j)];
}

// of a solve: a block a tile, a thread four columns of every sixteenth row
constexpr int kSolveThreads = 256, kColumns = 4, kRowThreads = kTile / kColumns,
              kRowStep = kSolveThreads / kRowThreads, kRows = kTile / kRowStep,
              kWarps = kSolveThreads / 32;

template <class T>
struct alignas(16) Columns {
  T value[kColumns];
};

template <class T>
struct DenseView {
  const T *tiles, *r;
  T* sums;
  unsigned* done;
  int tile_count;

  __device__ T* sum(int component, int I, int J) const {
    return sums + ((int64_t(component) * tile_count + I) * tile_count + J) * kTile;
  }
};

/// The sums of the rows of tile I, once all are there, to where z is.
template <class T>
__device__ void finish_rows(const DenseView<T>& d, const StencilView<T>& v, int component, int I,
                            T room[kSolveThreads], const ResultOutput<T>& out) {
  const int row = int(threadIdx.x) % kTile, first = int(threadIdx.x) / kTile;
  T sum = 0;
#pragma unroll 4
  for (int J = first; J < d.tile_count; J += kSolveThreads / kTile)
    sum += __ldcg(d.sum(component, I, J) + row);
  room[threadIdx.x] = sum;
  __syncthreads();
  const int node = kTile * I + row;
  if (first == 0 && node < v.nodes) {
    for (int k = 1; k < kSolveThreads / kTile; ++k) sum += room[k * kTile + row];
    if (out.z != nullptr)
      out.set(3 * int64_t(node) + component, sum);
    else
      v.z[3 * int64_t(v.slot[node]) + component] = sum;
  }
  __syncthreads();
}

/// Blocks (pairs of tiles, 3). Tiles come while kernels before still run: they are never written.
template <class T>
__global__ void __launch_bounds__(kSolveThreads)
    solve_kernel(DenseView<T> d, StencilView<T> v, ResultOutput<T> out) {
  __shared__ T of_rows[kTile], of_columns[kTile], room[kSolveThreads + kWarps * kTile];
  __shared__ bool last[2];
  const int thread = int(threadIdx.x), component = int(blockIdx.y);
  const int column = thread % kRowThreads, row = thread / kRowThreads;
  let_next_start();
  int I, J;
  find_tile(int(blockIdx.x), I, J);
  Columns<T> entry[kRows];
  const T* tile = d.tiles + (int64_t(component) * gridDim.x + blockIdx.x) * kBlock;
#pragma unroll
  for (int k = 0; k < kRows; ++k)
    entry[k] = read_early(reinterpret_cast<const Columns<T>*>(tile) + thread + kSolveThreads * k);
  wait_for_before();
  const T* r = d.r + int64_t(component) * d.tile_count * kTile;
  if (thread < kTile) of_rows[thread] = r[kTile * I + thread];
  if (thread >= kSolveThreads - kTile) {
    const int k = thread - (kSolveThreads - kTile);
    of_columns[k] = r[kTile * J + k];
  }
  __syncthreads();
  T along[kRows] = {}, down[kColumns] = {};
#pragma unroll
  for (int k = 0; k < kRows; ++k)
#pragma unroll
    for (int j = 0; j < kColumns; ++j) {
      along[k] += entry[k].value[j] * of_columns[kColumns * column + j];
      down[j] += entry[k].value[j] * of_rows[row + kRowStep * k];
    }
#pragma unroll
  for (int k = 0; k < kRows; ++k) {
    for (int half = kRowThreads / 2; half > 0; half /= 2)
      along[k] += __shfl_xor_sync(~0u, along[k], half);
    if (column == 0) d.sum(component, I, J)[row + kRowStep * k] = along[k];
  }
  T* const of_warps = room + kSolveThreads;
#pragma unroll
  for (int j = 0; j < kColumns; ++j) {
    down[j] += __shfl_xor_sync(~0u, down[j], kRowThreads);
    if (thread % 32 < kRowThreads) of_warps[thread / 32 * kTile + kColumns * column + j] = down[j];
  }
  __syncthreads();
  if (I != J && thread < kTile) {
    T sum = 0;
    for (int w = 0; w < kWarps; ++w) sum += of_warps[w * kTile + thread];
    d.sum(component, J, I)[thread] = sum;
  }
  __threadfence();
  __syncthreads();
  if (thread < 2) {
    const bool counts = thread == 0 || I != J;
    unsigned* const done = d.done + component * d.tile_count + (thread == 0 ? I : J);
    const auto all = unsigned(d.tile_count - 1);
    last[thread] = counts && atomicInc(done, all) == all;  // which sets it back to 0
    __threadfence();
  }
  __syncthreads();
  if (last[0]) finish_rows(d, v, component, I, room, out);
  if (last[1]) finish_rows(d, v, component, J, room, out);
}
static_assert(kRowThreads == 16);  // two rows a warp

/// The tiles of the inverses, 0 beyond row and column n.
template <class T>
void write_tiles(const double* swept, int64_t n, DeviceArray<T>& tiles) {
  const int64_t size = dense_pitch(n), pairs = pairs_of(size / kTile);
  T* const to = tiles.data();
  cuda::for_each(tiles.size(), [=] __device__(int64_t k) {
    const int j = int(k % kTile), i = int(k / kTile % kTile), m = int(k / (kBlock * pairs));
    int I, J;
    find_tile(int(k / kBlock % pairs), I, J);
    const int64_t row = int64_t(kTile) * I + i, column = int64_t(kTile) * J + j;
    if (row < n && column < n) to[k] = T(inverse_entry(swept, size, m, row, column));
  });
}

/// Whether room is counted alone: then the operators go here.
bool counts_only(const DeviceArray<double>& operators) {
  RoomCount* const room = RoomCount::present();
  if (room) room->take_off(size_t(operators.size()) * sizeof(double));
  return room != nullptr;
}

}  // namespace

template <class T>
DeviceArray<T> dense_inverses(DeviceArray<double> operators, int64_t n) {
  const int64_t size = dense_pitch(n);
  DeviceArray<T> inverses(kMatrices * n * size);
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
DenseSolve<T>::DenseSolve(DeviceArray<double> operators, int64_t n) {
  const int64_t size = dense_pitch(n), tiles = size / kTile, pairs = pairs_of(tiles);
  tiles_ = DeviceArray<T>(kMatrices * pairs * kBlock);
  r_ = DeviceArray<T>(kMatrices * size);
  sums_ = DeviceArray<T>(kMatrices * tiles * size);
  done_ = DeviceArray<unsigned>(kMatrices * tiles);
  if (counts_only(operators)) return;
  sweep(operators, size);
  write_tiles(operators.data(), n, tiles_);
  synchronise();  // the solve reads them without waiting for kernels before
}

template <class T>
void DenseSolve<T>::run(const StencilView<T>& level, const ResultOutput<T>& out) {
  const int tiles = int(done_.size() / kMatrices);
  const DenseView<T> view{tiles_.data(), r_.data(), sums_.data(), done_.data(), tiles};
  launch(solve_kernel<T>, dim3(unsigned(pairs_of(tiles)), kMatrices), kSolveThreads, 0, view, level,
         out);
}

template DeviceArray<float> dense_inverses(DeviceArray<double>, int64_t);
template DeviceArray<double> dense_inverses(DeviceArray<double>, int64_t);
template class DenseSolve<float>;
template class DenseSolve<double>;

}  // namespace elastogen::cuda
