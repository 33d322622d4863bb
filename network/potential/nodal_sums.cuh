// SPDX-License-Identifier: Apache-2.0
// Sums at the nodes over the voxels around them, of numbers that a voxel gives all its corners
// alike. A block of threads has a brick, as in brick_rows.cuh, but here nodes gather from voxels,
// so that one pass serves any count of numbers. Partial sums of shared nodes are added in the order
// of the bricks.

#pragma once

#include "network/potential/brick_rows.cuh"

namespace elastogen::cuda {
namespace bricks {

inline constexpr int kVoxels = kLanes * kLanes * kLanes;  // of a brick

/// Sum over the voxels of a brick around a node of its tile.
template <class T, int kCount>
__device__ inline void gather(const T* given, int place, T sum[kCount]) {
  constexpr int kWidth = ::elastogen::bricks::kTileWidth;
  const int x = place % kWidth, y = place / kWidth % kWidth, z = place / (kWidth * kWidth);
  for (int k = 0; k < kCount; ++k) sum[k] = 0;
#pragma unroll
  for (int c = 0; c < 8; ++c) {
    const int i = x - (c & 1), j = y - (c >> 1 & 1), l = z - (c >> 2);
    if (unsigned(i) >= kLanes || unsigned(j) >= kLanes || unsigned(l) >= kLanes) continue;
    for (int k = 0; k < kCount; ++k) sum[k] += given[k * kVoxels + i + kLanes * (j + kLanes * l)];
  }
}

/// Sums of one brick by a block. Shared memory has the values of the tile's nodes, and kCount
/// numbers for each place of a voxel, 0 where there is none. The block reads the tile, then eight
/// threads share a row of voxels and put each voxel's numbers into its place. Behind a barrier a
/// thread for each node adds those of the voxels around it. It finishes nodes that this brick alone
/// holds; sums of shared nodes go to `parts`, which shared_nodal_kernel adds up.
template <class T, int kCount, class Read, class Voxel, class Finish>
__global__ void __launch_bounds__(kThreads)
    nodal_kernel(RowsView g, T* parts, Read read, Voxel voxel, Finish finish) {
  extern __shared__ __align__(16) unsigned char scratch[];
  constexpr int kWidth = ::elastogen::bricks::kTileWidth;
  T *const in = reinterpret_cast<T*>(scratch), *const given = in + 3 * kTile;
  const int64_t b = blockIdx.x;
  const bool few = gridDim.x <= kFewBlocks;  // then the next kernel has few blocks too
  if (!few) let_next_start();
  // numbers of voxels, then their sums at nodes
  const int32_t begin = read_early(g.tile_begin + b), end = read_early(g.tile_begin + b + 1);
  const int lane = int(threadIdx.x) % kLanes;
  for (int k = int(threadIdx.x); k < kCount * kVoxels; k += kThreads) given[k] = 0;
  read_tile(g, begin, end, read, in, [] { wait_for_before(); });
  __syncthreads();
  const int32_t row_end = g.row_begin[b + 1];
  for (int32_t r = g.row_begin[b] + int32_t(threadIdx.x) / kLanes; r < row_end;
       r += kThreads / kLanes) {
    const VoxelRow row = g.rows[r];
    if (!(row.mask >> lane & 1)) continue;
    const int place = pitched(row.offset) + lane, line = row.offset / kWidth;
    T u[3][8], value[kCount];
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 8; ++c) u[i][c] = in[i * kTile + place + corner_offset(c)];
    voxel(row, int64_t(r), lane, u, value);
    T* const to = given + lane + kLanes * (line % kWidth + kLanes * (line / kWidth));
    for (int k = 0; k < kCount; ++k) to[k * kVoxels] = value[k];
  }
  if (few) let_next_start();
  __syncthreads();
  for (int32_t k = begin + int32_t(threadIdx.x); k < end; k += kThreads) {
    T sum[kCount];
    gather<T, kCount>(given, g.tile_place[k], sum);
    const int32_t part = g.tile_part[k];
    if (part < 0)
      finish(int64_t(g.tile_node[k]), sum);
    else
      for (int m = 0; m < kCount; ++m) parts[kCount * int64_t(part) + m] = sum[m];
  }
}

/// Finishes the nodes that bricks share, one thread for each.
template <class T, int kCount, class Finish>
__global__ void __launch_bounds__(kThreads)
    shared_nodal_kernel(RowsView g, const T* parts, Finish finish) {
  begin_kernel();
  const int64_t s = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (s >= g.shared) return;
  T sum[kCount] = {};
  for (int32_t p = g.shared_begin[s]; p < g.shared_begin[s + 1]; ++p)
    for (int k = 0; k < kCount; ++k) sum[k] += parts[kCount * int64_t(p) + k];
  finish(int64_t(g.shared_node[s]), sum);
}

}  // namespace bricks

/// Calls voxel(row, index of the row, lane, u, value) for every voxel: from its corner values u
/// (component, corner) it makes the kCount numbers that each corner gets. finish(node, sum) gets
/// their sum. read is as in for_each_voxel.
/// @param parts  memory for kCount rows.parts() numbers.
template <class T, int kCount, class Read, class Voxel, class Finish>
void sum_at_nodes(const DeviceRows& rows, T* parts, const Read& read, const Voxel& voxel,
                  const Finish& finish) {
  const RowsView g = rows.view();
  if (g.bricks == 0) return;
  const auto kernel = bricks::nodal_kernel<T, kCount, Read, Voxel, Finish>;
  constexpr int kBytes = (3 * bricks::kTile + kCount * bricks::kVoxels) * int(sizeof(T));
  check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, kBytes));
  launch(kernel, unsigned(g.bricks), bricks::kThreads, kBytes, g, parts, read, voxel, finish);
  if (g.shared == 0) return;
  const int64_t blocks = (g.shared + bricks::kThreads - 1) / bricks::kThreads;
  launch(bricks::shared_nodal_kernel<T, kCount, Finish>, unsigned(blocks), bricks::kThreads, 0, g,
         static_cast<const T*>(parts), finish);
}

}  // namespace elastogen::cuda
