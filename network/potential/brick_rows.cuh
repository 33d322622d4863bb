// SPDX-License-Identifier: Apache-2.0
// The loop of brick_rows.hpp on the device: one block of threads for each brick, one thread
// for each voxel, the tile in shared memory (core/cuda/tiles.cuh). Voxels add their results to the
// tile corner by corner, because no two voxels have the same node as the same corner.

#pragma once

#include "core/cuda/bricks.cuh"
#include "core/cuda/tiles.cuh"
#include "network/potential/brick_rows.hpp"

namespace elastogen::cuda {

/// The tables of BrickRows, as kernels read them.
struct RowsView : TilesView {
  const VoxelRow* rows;
  const int32_t* row_begin;
};

/// BrickRows of a scene and the weights of its voxels, made on the device.
class DeviceRows {
 public:
  /// @param level  the finest of make_stencil_levels.
  /// @throws Error (resources) if the device has too little memory.
  DeviceRows(const Scene& scene, const BrickLevel& level);

  RowsView view() const {
    return {{tile_begin_.data(), tile_node_.data(), tile_part_.data(), shared_node_.data(),
             shared_begin_.data(), tile_place_.data(), row_begin_.size() - 1, shared_node_.size()},
            rows_.data(),
            row_begin_.data()};
  }
  int64_t bricks() const { return row_begin_.size() - 1; }
  int64_t row_count() const { return rows_.size(); }
  /// Count of the partial sums that a loop needs, three numbers each.
  int64_t parts() const { return parts_; }

  /// Fill and variance weights, [row][5][lane].
  const DeviceArray<double>& weights() const { return weights_; }
  /// BrickRows::border.
  const DeviceArray<double>& border() const { return border_; }

  /// All tables, for tests.
  BrickRows download() const;

 private:
  void count(const BrickRows& g);
  struct Bricks;
  void make_rows(const Scene& scene, const Bricks& bricks);
  void make_tiles(const Bricks& bricks);

  DeviceArray<VoxelRow> rows_;
  DeviceArray<int32_t> row_begin_, tile_begin_, tile_node_, tile_part_, shared_node_, shared_begin_;
  DeviceArray<int16_t> tile_place_;
  DeviceArray<double> weights_, border_;
  int64_t parts_ = 0;
};

/// finish of a loop whose voxels give nothing to their corners.
struct NoFinish {
  template <class T>
  __device__ void operator()(int64_t, const NodeSum<T>&) const {}
};

namespace bricks {

template <class Finish>
inline constexpr bool kGives = !std::is_same_v<Finish, NoFinish>;

/// Bytes of shared memory of a block: the values of nodes and, unless NoFinish, their sums,
/// (3, kTile) each.
template <class T, class Finish>
inline constexpr int kSharedBytes = (kGives<Finish> ? 6 : 3) * kTile* int(sizeof(T));

/// Row r, or a row without voxels behind the last one; may be called before the wait.
__device__ inline VoxelRow row_at(const RowsView& g, int32_t r, int32_t end) {
  return r < end ? read_early(g.rows + r) : VoxelRow{};
}

/// Runs one brick by a block. Before the wait the block reads the brick's tables and first rows. It
/// then copies the values of the tile's nodes into shared memory. Eight threads share a row of
/// voxels: each calls voxel() with the corner values of its voxel in registers, while the next row
/// is being loaded. Behind a barrier for each corner, voxels add their results in shared memory. At
/// the end the block finishes nodes that this brick alone holds, stores its sums of shared nodes in
/// `parts`, and adds the Sums of its threads in a fixed order.
template <class T, class Sums, class Read, class Voxel, class Finish>
__global__ void __launch_bounds__(kThreads, sizeof(T) == 4 ? 2 : 1)
    voxel_kernel(RowsView g, T* parts, Sums* sums, Read read, Voxel voxel, Finish finish) {
  extern __shared__ __align__(16) unsigned char scratch[];
  T *const in = reinterpret_cast<T*>(scratch), *const given = in + 3 * kTile;
  const int64_t b = blockIdx.x;
  const bool few = gridDim.x <= kFewBlocks;  // then the next kernel has few blocks too
  if (!few) let_next_start();
  const int32_t begin = read_early(g.tile_begin + b), end = read_early(g.tile_begin + b + 1),
                row_begin = read_early(g.row_begin + b), row_end = read_early(g.row_begin + b + 1);
  // values of the tile's nodes
  const int lane = int(threadIdx.x) % kLanes;
  int32_t r = row_begin + int32_t(threadIdx.x) / kLanes;
  VoxelRow next = row_at(g, r, row_end);
  if constexpr (kGives<Finish>) clear_tile(given);
  read_tile(g, begin, end, read, in, [] { wait_for_before(); });
  __syncthreads();
  // voxels, eight threads a row
  Sums mine;
  for (int32_t first = row_begin; first < row_end; first += kThreads / kLanes) {
    const VoxelRow row = next;
    const int64_t number = r;
    r += kThreads / kLanes;
    next = row_at(g, r, row_end);
    const bool there = row.mask >> lane & 1;
    const int place = pitched(row.offset) + lane;
    T u[3][8], f[3][8];
    if (there) {
      for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 8; ++c) u[i][c] = in[i * kTile + place + corner_offset(c)], f[i][c] = 0;
      voxel(row, number, lane, u, f, mine);
    }
    for (int c = 0; kGives<Finish> && c < 8; ++c) {
      __syncthreads();
      if (there)
        for (int i = 0; i < 3; ++i) given[i * kTile + place + corner_offset(c)] += f[i][c];
    }
  }
  // sums of nodes and of the brick
  if (few) let_next_start();
  if constexpr (kGives<Finish>) {
    __syncthreads();
    finish_tile(g, begin, end, finish, given, parts);
  }
  if constexpr (!std::is_same_v<Sums, NoSums>) {
    __syncthreads();
    const Sums sum = block_sum(mine, reinterpret_cast<Sums*>(scratch));
    if (threadIdx.x == 0) sums[b] = sum;
  }
}

/// Finishes the nodes that bricks share, one thread for each; where there are Sums, the first block
/// adds those of the bricks instead.
template <class T, class Sums, class Finish, class Then>
__global__ void __launch_bounds__(kThreads)
    shared_kernel(RowsView g, const T* parts, const Sums* sums, Finish finish, Then then) {
  let_next_start();
  int64_t block = blockIdx.x;
  if constexpr (!std::is_same_v<Sums, NoSums>) {
    if (block-- == 0) {
      wait_for_before();
      alignas(Sums) __shared__ unsigned char all[kSumWarps * sizeof(Sums)];
      const Sums sum = detail::sum_of_partials(
          g.bricks, [&](int64_t k) { return sums[k]; }, reinterpret_cast<Sums*>(all));
      if (threadIdx.x == 0) then(sum);
      return;
    }
  }
  const int64_t s = block * kThreads + threadIdx.x;
  if (s >= g.shared) return;
  const int64_t node = read_early(g.shared_node + s);
  const NodeSum<T> sum{
      parts, read_early(g.shared_begin + s), read_early(g.shared_begin + s + 1), {}};
  wait_for_before();
  finish(node, sum);
}

/// For NoSums, which have no sum.
struct NoThen {
  __device__ void operator()(const NoSums&) const {}
};

}  // namespace bricks

/// Calls voxel(row, index of the row, lane, u, f, sums) for every voxel: u and f (component,
/// corner) are as in the loop of the CPU, and f is 0 at first. read is as there; finish(node, sum)
/// gets a NodeSum. Each brick's sums go to `sums`, (bricks), and one thread of the device calls
/// then(their sum); with NoSums neither happens. A Sums has add(other).
/// @param parts  memory for 3 rows.parts() numbers.
template <class T, class Sums, class Read, class Voxel, class Finish, class Then = bricks::NoThen>
void for_each_voxel(const DeviceRows& rows, T* parts, Sums* sums, const Read& read,
                    const Voxel& voxel, const Finish& finish, const Then& then = {}) {
  const RowsView g = rows.view();
  if (g.bricks == 0) return;
  const auto kernel = bricks::voxel_kernel<T, Sums, Read, Voxel, Finish>;
  constexpr int kBytes = bricks::kSharedBytes<T, Finish>;
  check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, kBytes));
  launch(kernel, unsigned(g.bricks), bricks::kThreads, kBytes, g, parts, sums, read, voxel, finish);
  const int64_t shared = bricks::kGives<Finish> ? g.shared : 0;
  const int64_t blocks =
      (shared + bricks::kThreads - 1) / bricks::kThreads + (std::is_same_v<Sums, NoSums> ? 0 : 1);
  if (blocks == 0) return;
  launch(bricks::shared_kernel<T, Sums, Finish, Then>, unsigned(blocks), bricks::kThreads, 0, g,
         static_cast<const T*>(parts), static_cast<const Sums*>(sums), finish, then);
}

}  // namespace elastogen::cuda
