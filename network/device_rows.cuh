// SPDX-License-Identifier: Apache-2.0
// The loop of network/brick_rows.hpp on the device: a block of threads a brick, a thread a voxel,
// the tile in shared memory. Voxels leave what they give their corners there, nodes gather it
// corner by corner, and partial sums of shared nodes are added in the order of the bricks: the same
// bits on every run, without atomics.

#pragma once

#include "core/device_reduce.cuh"
#include "network/brick_rows.hpp"

namespace elastogen::cuda {

/// The tables of BrickRows, as kernels take them.
struct RowsView {
  const VoxelRow* rows;
  const int32_t *row_begin, *tile_begin, *tile_node, *tile_part, *shared_node, *shared_begin;
  const int16_t* tile_place;
  int64_t bricks, shared;
};

class DeviceRows {
 public:
  explicit DeviceRows(const BrickRows& g)
      : rows_(g.rows),
        row_begin_(g.row_begin),
        tile_begin_(g.tile_begin),
        tile_node_(g.tile_node),
        tile_part_(g.tile_part),
        shared_node_(g.shared_node),
        shared_begin_(g.shared_begin),
        tile_place_(g.tile_place),
        parts_(g.shared_begin.empty() ? 0 : g.shared_begin.back()) {}

  RowsView view() const {
    return {rows_.data(),          row_begin_.data(),   tile_begin_.data(),   tile_node_.data(),
            tile_part_.data(),     shared_node_.data(), shared_begin_.data(), tile_place_.data(),
            row_begin_.size() - 1, shared_node_.size()};
  }
  int64_t bricks() const { return row_begin_.size() - 1; }
  int64_t row_count() const { return rows_.size(); }
  /// Partial sums that a loop in T needs, three numbers each.
  int64_t parts() const { return parts_; }

 private:
  DeviceArray<VoxelRow> rows_;
  DeviceArray<int32_t> row_begin_, tile_begin_, tile_node_, tile_part_, shared_node_, shared_begin_;
  DeviceArray<int16_t> tile_place_;
  int64_t parts_;
};

namespace bricks {

inline constexpr int kThreads = kSumThreads, kTile = ::elastogen::bricks::kTile;
inline constexpr int kCells = 512;  // of a brick

/// Shared memory of a block: values of the nodes, (3, kTile), and what each cell gives its corners,
/// (3, 8, kCells).
template <class T>
inline constexpr int kSharedBytes = (3 * kTile + 24 * kCells) * int(sizeof(T));

/// Place of a voxel's corner in the tile, from that of corner 0.
__device__ inline int corner_offset(int c) {
  return (c & 1) + (c & 2 ? 9 : 0) + (c & 4 ? 81 : 0);
}

/// What the cells around a node give one of its components.
template <class T>
__device__ inline T gathered(const T* of_corners, int place) {
  const int x = place % 9, y = place / 9 % 9, z = place / 81;
  T sum = 0;
  for (int c = 0; c < 8; ++c) {
    const int cell[3] = {x - (c & 1), y - (c >> 1 & 1), z - (c >> 2)};
    if ((cell[0] | cell[1] | cell[2]) < 0 || cell[0] > 7 || cell[1] > 7 || cell[2] > 7) continue;
    sum += of_corners[c * kCells + cell[0] + 8 * (cell[1] + 8 * cell[2])];
  }
  return sum;
}

template <class T, class Sums, class Read, class Voxel, class Finish>
__global__ void __launch_bounds__(kThreads, sizeof(T) == 4 ? 2 : 1)
    voxel_kernel(RowsView g, T* parts, Sums* sums, Read read, Voxel voxel, Finish finish) {
  extern __shared__ __align__(16) unsigned char room[];
  T *const in = reinterpret_cast<T*>(room), *const out = in + 3 * kTile;
  const int64_t b = blockIdx.x;
  const int32_t begin = g.tile_begin[b], end = g.tile_begin[b + 1], row_end = g.row_begin[b + 1];
  for (int k = threadIdx.x; k < 24 * kCells; k += kThreads) out[k] = 0;
  for (int k = begin + int(threadIdx.x); k < end; k += kThreads) {
    T value[3];
    read(int64_t(g.tile_node[k]), int64_t(g.tile_node[begin]), value);
    for (int i = 0; i < 3; ++i) in[i * kTile + g.tile_place[k]] = value[i];
  }
  __syncthreads();
  Sums mine;
  const int lane = int(threadIdx.x) % kLanes;
  for (int32_t r = g.row_begin[b] + int(threadIdx.x) / kLanes; r < row_end;
       r += kThreads / kLanes) {
    const VoxelRow row = g.rows[r];
    if (!(row.mask >> lane & 1)) continue;
    T u[3][8], f[3][8];
    const int place = row.offset + lane, line = row.offset / 9;
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 8; ++c) u[i][c] = in[i * kTile + place + corner_offset(c)], f[i][c] = 0;
    voxel(row, int64_t(r), lane, u, f, mine);
    const int cell = lane + 8 * (line % 9 + 8 * (line / 9));
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 8; ++c) out[(8 * i + c) * kCells + cell] = f[i][c];
  }
  __syncthreads();
  for (int k = begin + int(threadIdx.x); k < end; k += kThreads) {
    T sum[3];
    for (int i = 0; i < 3; ++i) sum[i] = gathered(out + 8 * i * kCells, g.tile_place[k]);
    const int32_t part = g.tile_part[k];
    if (part < 0)
      finish(int64_t(g.tile_node[k]), sum);
    else
      for (int i = 0; i < 3; ++i) parts[3 * int64_t(part) + i] = sum[i];
  }
  if constexpr (!std::is_same_v<Sums, NoSums>) {
    __syncthreads();
    const Sums sum = block_sum(mine, reinterpret_cast<Sums*>(room));
    if (threadIdx.x == 0) sums[b] = sum;
  }
}

}  // namespace bricks

/// voxel(row, index of the row, lane, u, f, sums) for every voxel: u and f (component, corner) as
/// in the loop of the CPU; f is 0 at first. read and finish as there. Each brick's sums go to sums
/// (bricks), which NoSums leaves alone; a Sums has add(other).
/// @param parts  3 rows.parts() numbers.
template <class T, class Sums, class Read, class Voxel, class Finish>
void for_each_voxel(const DeviceRows& rows, T* parts, Sums* sums, const Read& read,
                    const Voxel& voxel, const Finish& finish) {
  const RowsView g = rows.view();
  if (g.bricks == 0) return;
  const auto kernel = bricks::voxel_kernel<T, Sums, Read, Voxel, Finish>;
  constexpr int kBytes = bricks::kSharedBytes<T>;
  check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, kBytes));
  kernel<<<unsigned(g.bricks), bricks::kThreads, kBytes>>>(g, parts, sums, read, voxel, finish);
  check(cudaGetLastError());
  cuda::for_each(g.shared, [=] __device__(int64_t s) {
    T sum[3] = {};
    for (int32_t p = g.shared_begin[s]; p < g.shared_begin[s + 1]; ++p)
      for (int i = 0; i < 3; ++i) sum[i] += parts[3 * int64_t(p) + i];
    finish(int64_t(g.shared_node[s]), sum);
  });
}

}  // namespace elastogen::cuda
