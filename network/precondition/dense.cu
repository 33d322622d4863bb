// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/dense.cuh"

#include <cuda_pipeline.h>

namespace elastogen::cuda {
namespace {

constexpr int kTile = kDenseTile, kBlock = kTile * kTile;

// of the product: a thread has four columns of every sixteenth row of a tile
constexpr int kSolveThreads = 256, kColumns = 4, kRowThreads = kTile / kColumns,
              kRowStep = kSolveThreads / kRowThreads, kRows = kTile / kRowStep,
              kWarps = kSolveThreads / 32;
static_assert(kRowThreads == 16);  // two rows a warp

/// Tiles that a block loads before r is known: kKept into shared memory, one more into registers.
constexpr int kKept = 3, kEarly = kKept + 1;

template <class T>
struct alignas(16) Columns {
  T value[kColumns];
};

template <class T>
struct DenseView {
  const T* tiles;
  const T* partial;  ///< of the finer level, or nullptr: r is read instead
  T* sums;
  int tile_count;  ///< tiles in a row of a matrix

  __device__ int tiles_in_all() const { return kDenseMatrices * int(tile_pairs(tile_count)); }
  __device__ const Columns<T>* tile(int k) const {
    return reinterpret_cast<const Columns<T>*>(tiles + int64_t(k) * kBlock);
  }
  __device__ T* sum(int component, int I, int J) const {
    return sums + ((int64_t(component) * tile_count + I) * tile_count + J) * kTile;
  }
};

/// Component, row and column of a tile, from its number.
struct TilePlace {
  int component, I, J;
  TilePlace() = default;
  __device__ TilePlace(int k, int tile_count) {
    const int pairs = int(tile_pairs(tile_count));
    component = k / pairs;
    find_tile(k % pairs, I, J);
  }
};

/// Loads of tiles, which the L2 cache is to evict first: all tiles together would evict the data
/// that later kernels need.
struct Streaming {
  uint64_t policy;
  __device__ Streaming() {
    asm("createpolicy.fractional.L2::evict_first.b64 %0, 1.0;" : "=l"(policy));
  }
  __device__ int4 load(const int4* from) const {
    int4 v;
    asm volatile("ld.global.L1::no_allocate.L2::cache_hint.v4.b32 {%0, %1, %2, %3}, [%4], %5;"
                 : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
                 : "l"(from), "l"(policy));
    return v;
  }
  __device__ void copy(int4* shared, const int4* from) const {
    asm volatile("cp.async.cg.shared.global.L2::cache_hint [%0], [%1], 16, %2;" ::"r"(
                     unsigned(__cvta_generic_to_shared(shared))),
                 "l"(from), "l"(policy)
                 : "memory");
  }
};

/// Where r of a node is read from, for the rows (side 0) or columns (side 1) of a tile. The
/// constructor finds the place before r is known; get() reads it.
template <class T>
struct NodeResidual {
  const T* from;
  int component = 0;
  Restriction places;

  __device__ NodeResidual(const DenseView<T>& d, const StencilView<T>& v, int tile, int side,
                          int of)
      : from(d.partial != nullptr ? d.partial : v.r) {
    for (int32_t& p : places.place) p = -1;
    if (tile >= d.tiles_in_all()) return;
    const TilePlace at(tile, d.tile_count);
    component = at.component;
    const int node = kTile * (side == 0 ? at.I : at.J) + of;
    if (node >= v.nodes) return;
    const int slot = read_early(v.slot + node);
    if (d.partial != nullptr)
      places = Restriction(v.links, v.row, slot);
    else
      places.place[0] = slot;
  }
  __device__ T get() const { return places.sum(from, component); }
};

/// Shared memory of a block.
template <class T>
struct ProductScratch {
  Columns<T> kept[kKept][kRows * kSolveThreads];
  TilePlace place[kEarly];
  T of_warps[2][kWarps][kTile];
  T r[kEarly][2][kTile];  // of rows and of columns
};

/// Multiplies a tile with r of its columns, which gives a sum for each of its rows, and off the
/// diagonal its transpose with r of its rows, which gives a sum for each of its columns. A thread
/// holds 4x4 entries. The 16 threads of a row add up by shuffles; columns are added by shuffles
/// within a warp, then over the warps in shared memory. All orders are fixed.
/// @param of_warps  shared memory that no thread reads any more: two buffers take turns.
template <class T>
__device__ void multiply(const DenseView<T>& d, const Columns<T> entry[kRows], const T r[2][kTile],
                         const TilePlace at, T of_warps[kWarps][kTile]) {
  const int thread = int(threadIdx.x);
  const int column = thread % kRowThreads, row = thread / kRowThreads;
  T along[kRows] = {}, down[kColumns] = {};
#pragma unroll
  for (int k = 0; k < kRows; ++k)
#pragma unroll
    for (int j = 0; j < kColumns; ++j) {
      along[k] += entry[k].value[j] * r[1][kColumns * column + j];
      down[j] += entry[k].value[j] * r[0][row + kRowStep * k];
    }
  // halve twice: each of four threads ends with one of its four rows
  static_assert(kRows == 4);
  const bool upper = column & 8, odd = column & 4;
#pragma unroll
  for (int k = 0; k < 2; ++k)
    along[k] = (upper ? along[k + 2] : along[k]) +
               __shfl_xor_sync(~0u, upper ? along[k] : along[k + 2], 8);
  along[0] = (odd ? along[1] : along[0]) + __shfl_xor_sync(~0u, odd ? along[0] : along[1], 4);
  for (int half = 2; half > 0; half /= 2) along[0] += __shfl_xor_sync(~0u, along[0], half);
  if (column % 4 == 0)
    d.sum(at.component, at.I, at.J)[row + kRowStep * (2 * upper + odd)] = along[0];
#pragma unroll
  for (int j = 0; j < kColumns; ++j) {
    down[j] += __shfl_xor_sync(~0u, down[j], kRowThreads);
    if (thread % 32 < kRowThreads) of_warps[thread / 32][kColumns * column + j] = down[j];
  }
  __syncthreads();
  if (at.I == at.J || thread >= kTile) return;
  T sum = 0;
  for (int w = 0; w < kWarps; ++w) sum += of_warps[w][thread];
  d.sum(at.component, at.J, at.I)[thread] = sum;
}

/// Multiplies all tiles with r; row_sum_kernel adds the products up. A block has 256 threads and
/// several tiles, one after the other; the grid has no more blocks than the card holds at a time.
/// No kernel writes tiles, so a block loads them before it waits for the kernels that make r: the
/// first three into shared memory, the fourth into registers, and the rest are prefetched into the
/// L2 cache. Meanwhile it finds where r of these tiles is stored. After the wait it multiplies the
/// tile in registers, loads the next one into them while it multiplies those in shared memory, and
/// ends with the prefetched tiles one by one.
template <class T>
__global__ void __launch_bounds__(kSolveThreads, sizeof(T) == 4 ? 4 : 1)
    product_kernel(DenseView<T> d, StencilView<T> v) {
  extern __shared__ __align__(16) unsigned char shared[];
  auto& scratch = *reinterpret_cast<ProductScratch<T>*>(shared);
  constexpr int kLine = 128 / int(sizeof(Columns<T>));
  const int thread = int(threadIdx.x), count = d.tiles_in_all(), step = int(gridDim.x);
  // every block has kKept tiles; the rest go to the blocks that start first, because the last
  // ones start only when the kernel before ends
  const int rest = max(count - kKept * step, 0), columns = max((rest + step - 1) / step, 2);
  const int width = (rest + columns - 1) / columns;
  const auto tile = [&](int k) {
    const int block = int(blockIdx.x);
    if (k < kKept) return block + k * step;
    return block < width ? kKept * step + (k - kKept) * width + block : count;
  };
  let_next_start();
  constexpr int kParts = int(sizeof(Columns<T>) / sizeof(int4));
  const Streaming streaming;
  for (int k = 0; k < kKept && tile(k) < count; ++k)
    for (int m = thread; m < kRows * kSolveThreads * kParts; m += kSolveThreads)
      streaming.copy(reinterpret_cast<int4*>(scratch.kept[k]) + m,
                     reinterpret_cast<const int4*>(d.tile(tile(k))) + m);
  __pipeline_commit();
  Columns<T> entry[kRows];
  const auto load = [&](int k) {
    if (tile(k) >= count) return;
#pragma unroll
    for (int m = 0; m < kRows; ++m)
#pragma unroll
      for (int part = 0; part < kParts; ++part)
        reinterpret_cast<int4*>(&entry[m])[part] = streaming.load(
            reinterpret_cast<const int4*>(d.tile(tile(k)) + thread + kSolveThreads * m) + part);
  };
  load(kKept);
  for (int k = kEarly; tile(k) < count; ++k)  // into the L2 cache
    for (int m = kLine * thread; m < kRows * kSolveThreads; m += kLine * kSolveThreads)
      asm volatile("prefetch.global.L2 [%0];" ::"l"(d.tile(tile(k)) + m));
  const int side = thread / kTile % 2, of = thread % kTile, half = thread / (2 * kTile);
  static_assert(kSolveThreads == 4 * kTile && kEarly == 4);  // two tiles at once
  const NodeResidual<T> first(d, v, tile(half), side, of), second(d, v, tile(half + 2), side, of);
  if (thread < kEarly) scratch.place[thread] = TilePlace(tile(thread), d.tile_count);
  wait_for_before();
  scratch.r[half][side][of] = first.get();
  scratch.r[half + 2][side][of] = second.get();
  __pipeline_wait_prior(0);
  __syncthreads();
  int turn = 0;
  const auto run = [&](const Columns<T>* of_thread, int k) {
    if (tile(k) >= count) return;
    const int place = k < kEarly ? k : kKept;
    multiply(d, of_thread, scratch.r[place], scratch.place[place], scratch.of_warps[turn++ % 2]);
  };
  run(entry, kKept);
  for (int k = kEarly;; ++k) {
    // the next tile is being loaded while those in shared memory are multiplied
    load(k);
    if (half == 0) {
      const NodeResidual<T> later(d, v, tile(k), side, of);
      scratch.r[kKept][side][of] = later.get();
      if (thread == 0) scratch.place[kKept] = TilePlace(tile(k), d.tile_count);
    }
    if (k == kEarly)
      for (int m = 0; m < kKept; ++m) {
        Columns<T> kept[kRows];
        for (int j = 0; j < kRows; ++j) kept[j] = scratch.kept[m][thread + kSolveThreads * j];
        run(kept, m);
      }
    if (tile(k) >= count) return;
    __syncthreads();
    run(entry, k);
  }
}

/// z of the rows of a tile: the sum of the products of all tiles in its row. Grid (tiles in a row,
/// 3 components). Four threads share a row of the matrix: each adds every fourth product, then the
/// first one adds their sums in order.
template <class T>
__global__ void __launch_bounds__(kSolveThreads)
    row_sum_kernel(DenseView<T> d, StencilView<T> v, ResultOutput<T> out) {
  constexpr int kShares = kSolveThreads / kTile;
  __shared__ T scratch[kShares][kTile];
  const int row = int(threadIdx.x) % kTile, share = int(threadIdx.x) / kTile;
  const int I = int(blockIdx.x), component = int(blockIdx.y), node = kTile * I + row;
  let_next_start();
  const int slot = node < v.nodes ? read_early(v.slot + node) : 0;
  wait_for_before();
  T sum = 0;
#pragma unroll 8
  for (int J = share; J < d.tile_count; J += kShares) sum += d.sum(component, I, J)[row];
  scratch[share][row] = sum;
  __syncthreads();
  if (share > 0 || node >= v.nodes) return;
  for (int k = 1; k < kShares; ++k) sum += scratch[k][row];
  if (out.z != nullptr)
    out.set(3 * int64_t(node) + component, sum);
  else
    v.z[3 * int64_t(slot) + component] = sum;
}

/// Blocks of the product that the card holds at a time.
template <class T>
int resident_blocks() {
  constexpr int kBytes = sizeof(ProductScratch<T>);
  const auto kernel = product_kernel<T>;
  int device = 0, processors = 0, blocks = 0;
  check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, kBytes));
  check(cudaGetDevice(&device));
  check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device));
  check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, kernel, kSolveThreads, kBytes));
  return processors * blocks;
}

}  // namespace

template <class T>
DenseSolve<T>::DenseSolve(DeviceArray<double> operators, int64_t n) {
  const int64_t size = dense_pitch(n), tiles = size / kTile;
  tile_count_ = int(tiles);
  sums_ = DeviceArray<T>(kDenseMatrices * tiles * size);
  tiles_ = dense_inverse_tiles<T>(std::move(operators), n);
  if (MemoryCount::present()) return;
  blocks_ = std::min(resident_blocks<T>(), int(kDenseMatrices * tile_pairs(tiles)));
}

template <class T>
void DenseSolve<T>::run(const StencilView<T>& level, const T* partial, const ResultOutput<T>& out,
                        const LaunchOptions& options) {
  const DenseView<T> view{tiles_.data(), partial, sums_.data(), tile_count_};
  launch_on(options, product_kernel<T>, unsigned(blocks_), kSolveThreads, sizeof(ProductScratch<T>),
            view, level);
  launch(row_sum_kernel<T>, dim3(unsigned(tile_count_), kDenseMatrices), kSolveThreads, 0, view,
         level, out);
}

template class DenseSolve<float>;
template class DenseSolve<double>;

}  // namespace elastogen::cuda
