// SPDX-License-Identifier: Apache-2.0
// Loads and stores of a block of threads for a brick of stencil_bricks.hpp: the values of
// its 8x8x8 nodes and those around them, 10x10x10, into shared memory, rows of weights into
// registers, and the brick's share of the restricted residual to memory.

#pragma once

#include "network/precondition/stencil_bricks.hpp"

#include <cuda_pipeline.h>

namespace elastogen::cuda::stencil {

using ::elastogen::stencil::kComponent;
using ::elastogen::stencil::kPartial;
using ::elastogen::stencil::kRow;
using ::elastogen::stencil::kSlots;

inline constexpr int kPitch = 40;  // of a line of ten nodes in the tile: no bank conflicts
inline constexpr int kLine = 8 * 3, kBrick = 3 * kSlots, kTile = 100 * kPitch;

/// Coarse nodes per axis on or between which the nodes of a tile lie, from one before the brick on.
inline constexpr int kParents = 6, kCoarse = 3 * kParents * kParents * kParents;

/// Bytes of shared memory of a block: the tile, then the brick's r, which results replace, its z,
/// and the coarse values.
template <class T>
inline constexpr int kSharedBytes = (kTile + 2 * kBrick + kCoarse) * int(sizeof(T));

template <class T>
inline constexpr int kPart = 16 / int(sizeof(T));  // numbers in a copy of 16 bytes

template <class T>
struct alignas(16) Part {
  T value[kPart<T>];
};

template <class T>
__device__ inline void copy_part(T* to, const T* from) {
  __pipeline_memcpy_async(to, from, 16);
}

/// Copies links by the first threads of a block; may come before the wait.
__device__ inline void copy_links(const BrickLinks* from, BrickLinks* to) {
  constexpr int kWords = sizeof(BrickLinks) / sizeof(int32_t);
  static_assert(kWords <= 64);
  const int k = int(threadIdx.x);
  if (k < kWords)
    reinterpret_cast<int32_t*>(to)[k] = read_early(reinterpret_cast<const int32_t*>(from) + k);
}

/// Loads the values of a brick's nodes and those around them: ten lines of ten lines of ten nodes.
/// A line has first the eight nodes in parts, then the node before them and the one behind.
template <class T, int kThreads>
__device__ inline void load_tile(const BrickLinks& links, const T* p, T* tile) {
  constexpr int kParts = kLine / kPart<T>, kItems = kParts + 2;
  for (int k = int(threadIdx.x); k < 100 * kItems; k += kThreads) {
    const int line = k / kItems, item = k % kItems;
    const int y = line % 10 + 7, z = line / 10 + 7;  // plus 8
    const int side = item < kParts ? 1 : item == kParts ? 0 : 2;
    const int64_t brick = links.neighbour[side + 3 * (y >> 3) + 9 * (z >> 3)];
    const T* from = p + brick * kBrick + kLine * ((y & 7) + 8 * (z & 7));
    T* to = tile + kPitch * line + 4;
    if (side == 1) {
      copy_part(to + kPart<T> * item, from + kPart<T> * item);
      continue;
    }
    if (side == 0)
      from += kLine - 3, to -= 3;
    else
      to += kLine;
    for (int i = 0; i < 3; ++i) __pipeline_memcpy_async(to + i, from + i, sizeof(T));
  }
}

template <class T, int kThreads>
__device__ inline void load_brick(const T* from, T* to) {
  for (int k = kPart<T> * int(threadIdx.x); k < kBrick; k += kPart<T> * kThreads)
    copy_part(to + k, from + k);
}

template <class T, int kThreads>
__device__ inline void store_brick(const T* from, T* to) {
  for (int k = kPart<T> * int(threadIdx.x); k < kBrick; k += kPart<T> * kThreads)
    *reinterpret_cast<Part<T>*>(to + k) = *reinterpret_cast<const Part<T>*>(from + k);
}

/// Loads the coarse values around a brick, (kParents, kParents, kParents, 3).
template <class T, int kThreads>
__device__ inline void load_coarse(const BrickLinks& links, const T* z, T* coarse) {
  for (int k = int(threadIdx.x); k < kParents * kParents * kParents; k += kThreads) {
    const int parent[3] = {k % kParents, k / kParents % kParents, k / (kParents * kParents)};
    int brick = 0, place = 0;
    for (int d = 0; d < 3; ++d) {
      const int x = (links.odd >> d & 1 ? 3 : 7) + parent[d];
      brick += (x >> 3) << d;
      place += (x & 7) << (3 * d);
    }
    const T* from = z + (int64_t(links.coarse[brick]) * kSlots + place) * 3;
    for (int i = 0; i < 3; ++i) __pipeline_memcpy_async(coarse + 3 * k + i, from + i, sizeof(T));
  }
}

/// Adds P z of the coarse values to a component of nodes kFirst, ..., kFirst + kCount - 1 of line
/// (y, z) of the tile, 3 numbers apart: a node on a coarse one gets its value, others the mean of
/// those on both sides, axis by axis.
template <int kFirst, int kCount, class T>
__device__ inline void prolong_line(const T* coarse, int y, int z, T* line) {
  constexpr int kRow = 3 * kParents, kPlane = kParents * kRow;
  const int y0 = (y + y % 2) / 2, y1 = y / 2 + 1, z0 = (z + z % 2) / 2, z1 = z / 2 + 1;
  T parent[kParents];
#pragma unroll
  for (int x = kFirst / 2; x < kParents; ++x) {
    const T* at = coarse + 3 * x;
    parent[x] = ((at[kRow * y0 + kPlane * z0] + at[kRow * y1 + kPlane * z0]) +
                 (at[kRow * y0 + kPlane * z1] + at[kRow * y1 + kPlane * z1])) /
                4;
  }
#pragma unroll
  for (int j = 0; j < kCount; ++j) {
    const int x = kFirst + j;
    line[3 * j] += x % 2 == 1 ? parent[x / 2 + 1] : (parent[x / 2] + parent[x / 2 + 1]) / 2;
  }
}

/// Adds P z on all nodes of a tile, or of a brick.
template <class T, int kThreads>
__device__ inline void prolong_tile(const T* coarse, T* tile) {
  for (int k = int(threadIdx.x); k < 3 * 100; k += kThreads)
    prolong_line<0, 10>(coarse + k % 3, k / 3 % 10, k / 30, tile + kPitch * (k / 3) + 1 + k % 3);
}
template <class T, int kThreads>
__device__ inline void prolong_brick(const T* coarse, T* brick) {
  for (int k = int(threadIdx.x); k < 3 * 64; k += kThreads)
    prolong_line<1, 8>(coarse + k % 3, k / 3 % 8 + 1, k / 24 + 1, brick + kLine * (k / 3) + k % 3);
}

/// Loads nine values of a component around a node of one plane.
template <class T>
__device__ inline void load_plane(const T* at, T plane[9]) {
#pragma unroll
  for (int k = 0; k < 9; ++k) plane[k] = at[3 * (k % 3) + kPitch * (k / 3)];
}

template <class T>
__device__ inline void load_weights(const T* from, T weights[kComponent]) {
#pragma unroll
  for (int k = 0; k < kComponent; k += kPart<T>) {
    const Part<T> part = *reinterpret_cast<const Part<T>*>(from + k);
#pragma unroll
    for (int m = 0; m < kPart<T>; ++m) weights[k + m] = part.value[m];
  }
}

/// P^T of a line of eight fine values, at the five coarse nodes that begin at the first of them.
template <class T>
__device__ inline void restrict_line(const T* fine, int stride, T coarse[5]) {
  T d[8];
#pragma unroll
  for (int k = 0; k < 8; ++k) d[k] = fine[stride * k];
  coarse[0] = d[0] + d[1] / 2;
#pragma unroll
  for (int k = 1; k < 4; ++k) coarse[k] = d[2 * k] + (d[2 * k - 1] + d[2 * k + 1]) / 2;
  coarse[4] = d[7] / 2;
}

/// Stores the brick's share of P^T d, for the coarse nodes at 4 brick + (0 ... 4) per axis: axis by
/// axis, in place.
template <class T, int kThreads>
__device__ inline void store_partial(T* d, T* partial) {
  T coarse[5];
  for (int k = int(threadIdx.x); k < 3 * 64; k += kThreads) {
    T* const line = d + kLine * (k / 3) + k % 3;
    restrict_line(line, 3, coarse);
    for (int x = 0; x < 5; ++x) line[3 * x] = coarse[x];
  }
  __syncthreads();
  for (int k = int(threadIdx.x); k < 15 * 8; k += kThreads) {
    T* const line = d + 8 * kLine * (k / 15) + k % 15;
    restrict_line(line, kLine, coarse);
    for (int y = 0; y < 5; ++y) line[kLine * y] = coarse[y];
  }
  __syncthreads();
  for (int k = int(threadIdx.x); k < 15 * 5; k += kThreads) {
    restrict_line(d + kLine * (k / 15) + k % 15, 8 * kLine, coarse);
    for (int z = 0; z < 5; ++z) partial[75 * z + k] = coarse[z];
  }
}

}  // namespace elastogen::cuda::stencil
