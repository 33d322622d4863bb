// SPDX-License-Identifier: Apache-2.0
// The loop of network/brick_rows.hpp on the device: a block of threads a brick, a thread a voxel,
// the tile in shared memory. Voxels add what they give their corners there, corner by corner (no
// two voxels share a node as the same corner), and partial sums of shared nodes are added in the
// order of the bricks: the same bits on every run, without atomics.

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

/// Shared memory of a block: what nodes have and what they are given, (3, kTile) each.
template <class T>
inline constexpr int kSharedBytes = 6 * kTile* int(sizeof(T));

/// Place of a voxel's corner in the tile, from that of corner 0.
__device__ inline int corner_offset(int c) {
  return (c & 1) + (c & 2 ? 9 : 0) + (c & 4 ? 81 : 0);
}

template <class T, class Sums, class Read, class Voxel, class Finish>
__global__ void __launch_bounds__(kThreads, sizeof(T) == 4 ? 2 : 1)
    voxel_kernel(RowsView g, T* parts, Sums* sums, Read read, Voxel voxel, Finish finish) {
  extern __shared__ __align__(16) unsigned char room[];
  T *const in = reinterpret_cast<T*>(room), *const given = in + 3 * kTile;
  const int64_t b = blockIdx.x;
  const int32_t begin = g.tile_begin[b], end = g.tile_begin[b + 1], row_end = g.row_begin[b + 1];
  for (int k = threadIdx.x; k < 3 * kTile; k += kThreads) given[k] = 0;
  for (int k = begin + int(threadIdx.x); k < end; k += kThreads) {
    T value[3];
    read(int64_t(g.tile_node[k]), int64_t(g.tile_node[begin]), value);
    for (int i = 0; i < 3; ++i) in[i * kTile + g.tile_place[k]] = value[i];
  }
  __syncthreads();
  Sums mine;
  const int lane = int(threadIdx.x) % kLanes;
  for (int32_t first = g.row_begin[b]; first < row_end; first += kThreads / kLanes) {
    const int32_t r = first + int(threadIdx.x) / kLanes;
    const VoxelRow row = r < row_end ? g.rows[r] : VoxelRow{};
    const bool there = r < row_end && (row.mask >> lane & 1);
    const int place = row.offset + lane;
    T u[3][8], f[3][8];
    if (there) {
      for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 8; ++c) u[i][c] = in[i * kTile + place + corner_offset(c)], f[i][c] = 0;
      voxel(row, int64_t(r), lane, u, f, mine);
    }
    for (int c = 0; c < 8; ++c) {
      __syncthreads();
      if (there)
        for (int i = 0; i < 3; ++i) given[i * kTile + place + corner_offset(c)] += f[i][c];
    }
  }
  __syncthreads();
  for (int k = begin + int(threadIdx.x); k < end; k += kThreads) {
    T sum[3];
    for (int i = 0; i < 3; ++i) sum[i] = given[i * kTile + g.tile_place[k]];
    const int32_t part = g.tile_part[k];
    if (part < 0)
      finish(int64_t(g.tile_node[k]), sum);
    else
      for (int i = 0; i < 3; ++i) parts[3 * int64_t(part) + i] = sum[i];
  }
  if constexpr (!std::is_same_v<Sums, NoSums>) {
    static_assert(kThreads * sizeof(Sums) <= kSharedBytes<T>);
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
