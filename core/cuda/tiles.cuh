// SPDX-License-Identifier: Apache-2.0
// Tiles of bricks (core/bricks/tiles.hpp) on the device: one block of threads for each brick, its
// tile in shared memory. Partial sums of shared nodes are added in the order of the bricks, so
// every run gives the same bits without atomics.

#pragma once

#include "core/bricks/tiles.hpp"
#include "core/cuda/reduce.cuh"

namespace elastogen::cuda {

/// The tables of BrickTiles, as kernels read them.
struct TilesView {
  const int32_t *tile_begin, *tile_node, *tile_part, *shared_node, *shared_begin;
  const int16_t* tile_place;
  int64_t bricks, shared;
};

/// The sum of what voxels give a node. get() reads its parts; called late, it follows other loads.
template <class T>
struct NodeSum {
  const T* parts;  ///< of the bricks that share it, three numbers each
  int32_t begin, end;
  T rest[3];  ///< of the only brick, where there are no parts

  __device__ void get(T sum[3]) const {
    for (int i = 0; i < 3; ++i) sum[i] = rest[i];
    for (int32_t p = begin; p < end; ++p)
      for (int i = 0; i < 3; ++i) sum[i] += parts[3 * int64_t(p) + i];
  }
};

namespace bricks {

inline constexpr int kThreads = kSumThreads;

// A tile in shared memory has lines of kPitch numbers: rows of eight voxels that follow each other
// along y lie in different banks, four of them in float, two in double.
inline constexpr int kPitch = 24, kTile = ::elastogen::bricks::kLines * kPitch;

/// Place in this tile of a node, or of a row of voxels, with that place in the tile of the CPU.
__device__ inline int pitched(int place) {
  constexpr int kWidth = ::elastogen::bricks::kTileWidth;
  return place + place / kWidth * (kPitch - kWidth);
}

/// Place of a voxel's corner in the tile, from that of corner 0.
__device__ inline int corner_offset(int c) {
  return (c & 1) + (c & 2 ? kPitch : 0) + (c & 4 ? 9 * kPitch : 0);
}

/// Nodes of a tile that a thread reads and finishes; it issues all loads before it needs the first.
inline constexpr int kNodes = (::elastogen::bricks::kTile + kThreads - 1) / kThreads;

/// Sets the numbers of a tile to 0, 16 bytes at a time.
template <class T>
__device__ inline void clear_tile(T* given) {
  static_assert(3 * kTile * sizeof(T) % sizeof(int4) == 0);
  int4* const parts = reinterpret_cast<int4*>(given);
  for (int k = int(threadIdx.x); k < int(3 * kTile * sizeof(T) / sizeof(int4)); k += kThreads)
    parts[k] = int4{};
}

/// Reads the three values of the nodes [begin, end) by read(node, reference, value) and puts them
/// into their places in the tile; reference is the first node. A thread first loads the tables of
/// all its nodes, which no kernel writes, then calls begin_reads, then reads all values before it
/// stores the first.
/// @param in           (3, kTile).
/// @param begin_reads  called before anything is read that kernels write.
template <class T, class Read, class Begin>
__device__ inline void read_tile(const TilesView& g, int32_t begin, int32_t end, const Read& read,
                                 T* in, const Begin& begin_reads) {
  const int64_t reference = read_early(g.tile_node + begin);
  int32_t node[kNodes], place[kNodes];
  T value[kNodes][3];
#pragma unroll
  for (int j = 0; j < kNodes; ++j) {
    const int32_t k = begin + int32_t(threadIdx.x) + j * kThreads;
    node[j] = k < end ? read_early(g.tile_node + k) : -1;
    place[j] = k < end ? pitched(read_early(g.tile_place + k)) : 0;
  }
  begin_reads();
#pragma unroll
  for (int j = 0; j < kNodes; ++j)
    if (node[j] >= 0) read(int64_t(node[j]), reference, value[j]);
#pragma unroll
  for (int j = 0; j < kNodes; ++j)
    if (node[j] >= 0)
      for (int i = 0; i < 3; ++i) in[i * kTile + place[j]] = value[j][i];
}

/// Calls finish(node, NodeSum) for the nodes [begin, end) that this brick alone holds; the sums of
/// the others go to `parts`.
/// @param given  (3, kTile).
template <class T, class Finish>
__device__ inline void finish_tile(const TilesView& g, int32_t begin, int32_t end,
                                   const Finish& finish, const T* given, T* parts) {
  int32_t node[kNodes], part[kNodes], place[kNodes];
#pragma unroll
  for (int j = 0; j < kNodes; ++j) {
    const int32_t k = begin + int32_t(threadIdx.x) + j * kThreads;
    node[j] = k < end ? g.tile_node[k] : -1;
    part[j] = k < end ? g.tile_part[k] : 0;
    place[j] = k < end ? pitched(g.tile_place[k]) : 0;
  }
#pragma unroll
  for (int j = 0; j < kNodes; ++j) {
    if (node[j] < 0) continue;
    NodeSum<T> sum{nullptr, 0, 0, {}};
    for (int i = 0; i < 3; ++i) sum.rest[i] = given[i * kTile + place[j]];
    if (part[j] < 0)
      finish(int64_t(node[j]), sum);
    else
      for (int i = 0; i < 3; ++i) parts[3 * int64_t(part[j]) + i] = sum.rest[i];
  }
}

}  // namespace bricks

}  // namespace elastogen::cuda
