// SPDX-License-Identifier: Apache-2.0
// Tables of a level while it is made (multigrid_grid.cu): voxels and nodes by slot, the row of a
// node, and the numbering of distinct rows.

#pragma once

#include "core/cuda/bricks.cuh"
#include "core/cuda/reduce.cuh"
#include "network/precondition/stencil_bricks.hpp"

namespace elastogen::cuda {

using stencil::kComponent;
using stencil::kRow;

/// Data of the slots of a level.
struct SlotTables : BrickTables {
  double* moduli;         ///< as LevelGrid's [Pa], (6, slots)
  double* inertia;        ///< a0 m / dt^2 [N/m], (slots)
  uint8_t* pinned;        ///< (slots)
  const int32_t* border;  ///< lane + kLanes border of the finest level's voxels, -1: full
  const double* moments;  ///< [border][7][lane]
  const double* folded;   ///< of stencil_folded.cuh, or nullptr

  __device__ bool is_free(int64_t slot) const { return has_node(slot) && !pinned[slot]; }
};

/// Makes the row of a node.
template <class T>
struct RowSource {
  SlotTables level;
  double scale, unit;  ///< moduli times h over the level's unit; inertia over the unit

  /// Calls take(k, number) for the numbers of a row, (3, kComponent).
  template <class Take>
  __device__ void for_numbers(int64_t slot, const Take& take) const {
    const Place at(slot);
    const int32_t* around = level.links[slot / kSlots].neighbour;
    // voxels around the node, and which nodes around it are pinned
    int64_t corner[8];
    for (int c = 0; c < 8; ++c) {
      corner[c] = level.slot_at(around, at.x - (c & 1), at.y - (c >> 1 & 1), at.z - (c >> 2));
      if (corner[c] >= 0 && !level.has_voxel(corner[c])) corner[c] = -1;
    }
    uint32_t pins = 0;
    for (int j = 0; j < 27; ++j) {
      const int64_t there =
          level.slot_at(around, at.x + j % 3 - 1, at.y + j / 3 % 3 - 1, at.z + j / 9 - 1);
      if (there >= 0 && level.pinned[there]) pins |= 1u << j;
    }
    const auto voxel = [&](int c, double k[6], double M[7]) {
      if (corner[c] < 0) return false;
      for (int j = 0; j < 6; ++j)
        k[j] = double(T(level.moduli[j * level.slots() + corner[c]] * scale));
      const int32_t border = level.border == nullptr ? -1 : level.border[corner[c]];
      for (int m = 0; m < 7; ++m)
        M[m] = border < 0
                   ? 0
                   : level.moments[(border / kLanes * 7 + m) * int64_t(kLanes) + border % kLanes];
      return true;
    };
    // the row, component by component
    for (int i = 0; i < 3; ++i) {
      T added = T(level.inertia[slot] / unit), row[kComponent];
      if (level.folded != nullptr) added += T(level.folded[3 * slot + i] / unit);
      stencil_row<T>(i, voxel, pins, added, row);
      for (int j = 0; j < kComponent; ++j) take(i * kComponent + j, row[j]);
    }
  }

  __device__ static uint64_t bits_of(T value) {
    if constexpr (sizeof(T) == 4)
      return __float_as_uint(value);
    else
      return uint64_t(__double_as_longlong(value));
  }

  /// Hash of the row of a slot, never 0.
  __device__ uint64_t hash(int64_t slot, uint64_t bits) const {
    uint64_t h = 0;
    for_numbers(slot, [&](int, T value) {
      h ^= bits_of(value);
      h *= 0x9e3779b97f4a7c15;
      h ^= h >> 29;
    });
    return (h & bits) == 0 ? 1 : h & bits;
  }
};

/// A hash table with the first slot of each key, for any order of threads.
struct FirstSlots {
  unsigned long long* keys;
  int32_t* first;
  uint64_t mask;  ///< entries less 1, a power of two

  /// Enters a slot, and gives the entry of its key. Threads of a warp with equal keys insert once.
  __device__ uint64_t take(uint64_t key, int32_t slot) const {
    const unsigned together = __match_any_sync(__activemask(), key);
    const int leader = __ffs(int(together)) - 1;  // it has the first slot of them
    uint64_t entry = 0;
    if (int(threadIdx.x) % 32 == leader) entry = insert(key, slot);
    return __shfl_sync(together, entry, leader);
  }

 private:
  __device__ uint64_t insert(uint64_t key, int32_t slot) const {
    for (uint64_t entry = key & mask;; entry = (entry + 1) & mask) {
      const unsigned long long found = atomicCAS(keys + entry, 0ull, (unsigned long long)(key));
      if (found != 0 && found != key) continue;
      if (first[entry] > slot) atomicMin(first + entry, slot);
      return entry;
    }
  }
};

/// Numbers first slots of keys, one block for each brick, a thread for each slot. The block counts
/// its first slots. Without `base` it only stores that count in `counts`; else they get the next
/// numbers behind base[brick], in the order of slots, and write their rows.
template <class T>
__global__ void __launch_bounds__(kSlots)
    number_kernel(RowSource<T> source, FirstSlots of, const uint64_t* entry, const int32_t* base,
                  int32_t* counts, int32_t* row, T* rows) {
  __shared__ int32_t before[kSlots / 32];
  const int64_t slot = int64_t(blockIdx.x) * kSlots + threadIdx.x;
  const int warp = int(threadIdx.x) / 32, lane = int(threadIdx.x) % 32;
  begin_kernel();
  const bool pending = source.level.is_free(slot) && row[slot] == 0;
  const bool is_first = pending && of.first[entry[slot]] == int32_t(slot);
  const int count = __syncthreads_count(is_first);
  if (base == nullptr) {
    if (threadIdx.x == 0) counts[blockIdx.x] = count;
    return;
  }
  const unsigned of_warp = __ballot_sync(~0u, is_first);
  if (lane == 0) before[warp] = __popc(of_warp);
  __syncthreads();
  if (!is_first) return;
  int32_t number = base[blockIdx.x] + __popc(of_warp & ((1u << lane) - 1));
  for (int w = 0; w < warp; ++w) number += before[w];
  T* to = rows + int64_t(number) * kRow;
  source.for_numbers(slot, [&](int k, T value) { to[k] = value; });
  row[slot] = number;
}

}  // namespace elastogen::cuda
