// SPDX-License-Identifier: Apache-2.0
// Sums over numbers of the device in float64 and in an order that never changes, which stay on the
// device: the same bits on every run of a card, without a round trip to the host.

#pragma once

#include "core/device_array.cuh"

namespace elastogen::cuda {

/// K sums that are taken together.
template <int K>
struct Sums {
  double value[K] = {};
  __device__ void add(const Sums& other) {
    for (int k = 0; k < K; ++k) value[k] += other.value[k];
  }
};

inline constexpr int kSumThreads = 256, kSumBlocks = 512;

inline constexpr int kSumWarps = kSumThreads / 32;

/// That of the lane `step` above in the warp.
template <class Sum>
__device__ inline Sum from_above(const Sum& mine, int step) {
  static_assert(sizeof(Sum) % sizeof(int) == 0);
  constexpr int kWords = sizeof(Sum) / sizeof(int);
  struct alignas(Sum) Words {
    int word[kWords];
  };
  Words words = __builtin_bit_cast(Words, mine);
#pragma unroll
  for (int k = 0; k < kWords; ++k)
    words.word[k] = __shfl_down_sync(~0u, words.word[k], unsigned(step));
  return __builtin_bit_cast(Sum, words);
}

/// The sum over the threads of a block in a fixed order, for thread 0 alone, in a register. `all`
/// holds kSumWarps Sums of shared memory.
template <class Sum>
__device__ inline Sum block_sum(const Sum& mine, Sum* all) {
  Sum sum = mine;
  for (int step = 16; step > 0; step /= 2) sum.add(from_above(sum, step));
  if (threadIdx.x % 32 == 0) all[threadIdx.x / 32] = sum;
  __syncthreads();
  if (threadIdx.x == 0)
    for (int warp = 1; warp < kSumWarps; ++warp) sum.add(all[warp]);
  return sum;
}

/// The same of many sums: at each step a lane hands half of its numbers to its partner and takes
/// over the partner's other half, until it has one number of a few lanes.
template <int K>
__device__ inline Sums<K> block_sum(const Sums<K>& mine, Sums<K>* all) {
  static_assert(K <= 16);
  constexpr int kNumbers = K > 8 ? 16 : K > 4 ? 8 : K > 2 ? 4 : K;
  const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
  double value[kNumbers];
#pragma unroll
  for (int k = 0; k < kNumbers; ++k) value[k] = k < K ? mine.value[k] : 0;
  int number = 0, step = 16;
#pragma unroll
  for (int width = kNumbers / 2; width > 0; width /= 2, step /= 2) {
    const bool upper = lane & step;
    if (upper) number += width;
#pragma unroll
    for (int k = 0; k < width; ++k) {
      const double given = upper ? value[k] : value[k + width];
      const double kept = upper ? value[k + width] : value[k];
      value[k] = kept + __shfl_xor_sync(~0u, given, step);
    }
  }
  const int apart = 2 * step;  // lanes that have different numbers
  for (; step > 0; step /= 2) value[0] += __shfl_xor_sync(~0u, value[0], step);
  if (lane % apart == 0 && number < K) all[warp].value[number] = value[0];
  __syncthreads();
  Sums<K> sum;
  if (warp > 0) return sum;
  if (lane < K) {
    double total = 0;
    for (int w = 0; w < kSumWarps; ++w) total += all[w].value[lane];
    all[0].value[lane] = total;
  }
  __syncwarp();
  if (lane == 0) sum = all[0];
  return sum;
}

/// What a sum over the device needs there; zero at first, as a DeviceArray is at birth.
template <class Sum>
struct SumRoom {
  Sum partial[kSumBlocks];
  unsigned done;  ///< blocks; 0 between the launches
};

namespace detail {

/// The sum of partial[0, n) by a block, each thread taking every kSumThreads-th.
template <class Sum>
__device__ inline Sum sum_of_partials(int64_t n, const Sum* partial, Sum* all) {
  Sum mine;
  for (int64_t k = threadIdx.x; k < n; k += kSumThreads) mine.add(partial[k]);
  return block_sum(mine, all);
}

/// The block that ends last adds what all have left, in the order of the blocks: which one that is
/// does not matter.
template <class Sum, class Body, class Then>
__global__ void __launch_bounds__(kSumThreads, 4)
    ordered_sum_kernel(int64_t n, SumRoom<Sum>* room, Body body, Then then) {
  alignas(Sum) __shared__ unsigned char all[kSumWarps * sizeof(Sum)];
  __shared__ bool last;
  begin_kernel();
  Sum mine;
  for (int64_t i = int64_t(blockIdx.x) * kSumThreads + threadIdx.x; i < n;
       i += int64_t(gridDim.x) * kSumThreads)
    body(i, mine);
  const Sum of_block = block_sum(mine, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) {
    room->partial[blockIdx.x] = of_block;
    __threadfence();
    last = atomicInc(&room->done, gridDim.x - 1) == gridDim.x - 1;  // the last sets it back to 0
    __threadfence();
  }
  __syncthreads();
  if (!last) return;
  const Sum sum = sum_of_partials(gridDim.x, room->partial, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) then(sum);
}

}  // namespace detail

/// Adds body(i, sum) over i of [0, n), then then(sum) by one thread of the device; a Sum has
/// add(other).
template <class Sum, class Body, class Then>
void ordered_sum(int64_t n, SumRoom<Sum>* room, const Body& body, const Then& then) {
  const int64_t blocks = (n + kSumThreads - 1) / kSumThreads;
  const auto launched = unsigned(blocks < 1 ? 1 : blocks > kSumBlocks ? kSumBlocks : blocks);
  launch(detail::ordered_sum_kernel<Sum, Body, Then>, launched, kSumThreads, 0, n, room, body,
         then);
}

}  // namespace elastogen::cuda
