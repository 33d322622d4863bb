// SPDX-License-Identifier: Apache-2.0
// The passes of the V-cycle over a level, brick by brick.

#pragma once

#include "network/precondition/stencil.cuh"
#include "network/precondition/stencil_tile.cuh"

namespace elastogen::cuda {

/// The passes over a level, each with one product A p.
enum class Pass {
  kStart,     ///< z = p + keep p + add D^-1 (r - A p), p = first D^-1 r in `other`: both steps
  kResidual,  ///< `partial` = the brick's share of P^T (r - A z)
  kFirst,     ///< other = z' + first D^-1 (r - A z'), z' = z + P times the coarser level's z
  kSecond     ///< z = p + keep (p - z') + add D^-1 (r - A p), p in `other`
};

namespace stencil {

/// The result of a pass at one number, from p and the residual r - A p.
template <class T>
__device__ inline T updated(const StencilView<T>& v, Pass pass, T p, T before, T inverse,
                            T residual) {
  if (pass == Pass::kResidual) return residual;
  if (pass == Pass::kFirst) return p + v.first * inverse * residual;
  return p + (v.keep * (p - before) + v.add * inverse * residual);
}

/// Updates one component of kRun nodes, from the lowest up.
/// @param at     tile, one node before the lowest along each axis.
/// @param own    r of the lowest, which the result replaces where there is a free node.
/// @param old    z' of the lowest.
/// @param added  additional stiffness of the lowest, nullptr: none.
template <class T, int kRun, bool kAdded>
__device__ inline void update_column(const StencilView<T>& v, Pass pass, int component,
                                     const int32_t row[kRun], const T* at, T* own, const T* old,
                                     const T* added) {
  T planes[3][9], weights[kComponent];
  load_plane(at, planes[0]);
  load_plane(at + 10 * kPitch, planes[1]);
#pragma unroll
  // three planes of values are in registers; weights are loaded again where the row changes
  for (int j = 0; j < kRun; ++j) {
    load_plane(at + 10 * kPitch * (j + 2), planes[(j + 2) % 3]);
    if (j == 0 || row[j] != row[j - 1])
      load_weights(v.rows + int64_t(row[j]) * kRow + component * kComponent, weights);
    T sum[3] = {};
#pragma unroll
    for (int k = 0; k < 9; ++k)
#pragma unroll
      for (int plane = 0; plane < 3; ++plane)
        sum[plane] += weights[9 * plane + k] * planes[(j + plane) % 3][k];
    const int place = 64 * 3 * j;
    const T before = pass == Pass::kSecond ? old[place] : T(0);
    const T p = planes[(j + 1) % 3][4];
    T residual = own[place] - ((sum[0] + sum[1]) + sum[2]), inverse = weights[27];
    if (kAdded && added != nullptr) {
      residual -= added[place] * p;
      inverse = v.with_added(inverse, added[place]);
    }
    if (row[j] != 0) own[place] = updated(v, pass, p, before, inverse, residual);
  }
}

/// Updates one component of a single node whose weights are loaded already.
template <class T>
__device__ inline void update_node(const StencilView<T>& v, Pass pass, const T weights[kComponent],
                                   const T* at, T* own, const T* old) {
  T sum[3] = {};
#pragma unroll
  for (int plane = 0; plane < 3; ++plane) {
    T values[9];
    load_plane(at + 10 * kPitch * plane, values);
#pragma unroll
    for (int k = 0; k < 9; ++k) sum[plane] += weights[9 * plane + k] * values[k];
  }
  const T before = pass == Pass::kSecond ? *old : T(0);
  const T residual = *own - ((sum[0] + sum[1]) + sum[2]);
  *own = updated(v, pass, at[10 * kPitch + kPitch + 3], before, weights[27], residual);
}

/// Stores the results of a brick where the pass leaves them; `out` as in run_pass.
template <class T, int kThreads>
__device__ inline void store(const StencilView<T>& v, Pass pass, int64_t brick, T* own,
                             const ResultOutput<T>& out) {
  if (pass == Pass::kResidual)
    return store_partial<T, kThreads>(own, v.partial + brick * 3 * kPartial);
  if (out.z == nullptr || pass != Pass::kSecond)
    return store_brick<T, kThreads>(own, (pass == Pass::kFirst ? v.other : v.z) + brick * kBrick);
  const int32_t begin = v.begin[brick], count = v.begin[brick + 1] - begin;
  constexpr int kNodes = kSlots / kThreads;
  int place[kNodes];
#pragma unroll
  for (int j = 0; j < kNodes; ++j) {
    const int n = int(threadIdx.x) + j * kThreads;
    place[j] = n < count ? 3 * (v.slot[begin + n] % kSlots) : -1;
  }
#pragma unroll
  for (int j = 0; j < kNodes; ++j) {
    if (place[j] < 0) continue;
    const int64_t k = 3 * (int64_t(begin) + int(threadIdx.x) + j * kThreads);
    for (int i = 0; i < 3; ++i) out.set(k + i, own[place[j] + i]);
  }
}

/// A pass over one brick by a block of 512 / kRun threads. Shared memory gets the values p of its
/// nodes and those around them, and r. A thread owns kRun nodes of a column along z and keeps
/// values and weights in registers while it goes up. Nothing is scattered; sums have a fixed order.
/// @param scratch   kSharedBytes<T> of shared memory, aligned to 16.
/// @param out    z by node for the last pass of the finest level.
/// @param begin  called before anything is read that kernels write.
/// @tparam kAdded  the view has an additional stiffness.
template <class T, int kRun, bool kAdded, class Begin>
__device__ inline void run_pass(const StencilView<T>& v, Pass pass, int64_t brick, T* scratch,
                                const ResultOutput<T>& out, const Begin& begin) {
  // all weights are loaded before the values
  constexpr bool kEarlyWeights = kRun == 1 && sizeof(T) == 4 && !kAdded;
  constexpr int kThreads = kSlots / kRun;
  T *const own = scratch + kTile, *const old = own + kBrick;
  T* const coarse = pass == Pass::kSecond ? old + kBrick : old;
  const bool prolongs = v.coarse_z != nullptr && (pass == Pass::kFirst || pass == Pass::kSecond);
  const int x = int(threadIdx.x) % 8, y = int(threadIdx.x) / 8 % 8;
  const int z = kRun * (int(threadIdx.x) / 64), place = x + 8 * (y + 8 * z);
  const bool from_z = pass == Pass::kResidual || pass == Pass::kFirst;
  __shared__ BrickLinks links;
  copy_links(v.links + brick, &links);
  int32_t row[kRun], any = 0;
  for (int j = 0; j < kRun; ++j)
    any |= row[j] = read_early(v.row + brick * kSlots + place + 64 * j);
  begin();
  T weights[3][kEarlyWeights ? kComponent : 1];
  if constexpr (kEarlyWeights)
    for (int i = 0; i < 3; ++i)
      if (any != 0) load_weights(v.rows + int64_t(any) * kRow + i * kComponent, weights[i]);
  __syncthreads();
  load_tile<T, kThreads>(links, from_z ? v.z : v.other, scratch);
  load_brick<T, kThreads>(v.r + brick * kBrick, own);
  if (pass == Pass::kSecond) load_brick<T, kThreads>(v.z + brick * kBrick, old);
  if (prolongs) load_coarse<T, kThreads>(links, v.coarse_z, coarse);
  __pipeline_commit();
  const auto wait = [&] {
    __pipeline_wait_prior(0);
    __syncthreads();
    if (!prolongs) return;
    if (pass == Pass::kFirst)
      prolong_tile<T, kThreads>(coarse, scratch);
    else
      prolong_brick<T, kThreads>(coarse, old);
    __syncthreads();
  };
  // r and the result are 0 where there is no free node
  const T* const at = scratch + kPitch * (y + 10 * z) + 3 * x + 1;
  wait();
  if constexpr (kEarlyWeights) {
    for (int i = 0; i < 3; ++i)
      if (any != 0)
        update_node(v, pass, weights[i], at + i, own + 3 * place + i, old + 3 * place + i);
  } else {
    const T* added = nullptr;
    if (kAdded && v.stiff[brick] != 0) added = v.added + brick * kBrick + 3 * place;
#pragma unroll 1
    for (int i = 0; i < 3; ++i)
      if (any != 0)
        update_column<T, kRun, kAdded>(v, pass, i, row, at + i, own + 3 * place + i,
                                       old + 3 * place + i, added == nullptr ? added : added + i);
  }
  __syncthreads();
  store<T, kThreads>(v, pass, brick, own, out);
}

}  // namespace stencil
}  // namespace elastogen::cuda
