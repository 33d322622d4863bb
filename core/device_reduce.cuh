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

/// The sum over the threads of a block in a fixed order, for thread 0 alone, in a register. `all`
/// holds kSumThreads Sums of shared memory.
template <class Sum>
__device__ inline Sum block_sum(const Sum& mine, Sum* all) {
  Sum sum = mine;
  all[threadIdx.x] = sum;
  for (int half = kSumThreads / 2; half > 0; half /= 2) {
    __syncthreads();
    if (threadIdx.x >= half) continue;
    sum.add(all[threadIdx.x + half]);
    if (half > 1) all[threadIdx.x] = sum;
  }
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
  alignas(Sum) __shared__ unsigned char all[kSumThreads * sizeof(Sum)];
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

template <class Sum, class Then>
__global__ void __launch_bounds__(kSumThreads) total_sum(int64_t n, const Sum* partial, Then then) {
  alignas(Sum) __shared__ unsigned char all[kSumThreads * sizeof(Sum)];
  begin_kernel();
  const Sum sum = sum_of_partials(n, partial, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) then(sum);
}

}  // namespace detail

/// then(sum of partial) by one thread of the device; a Sum has add(other).
template <class Sum, class Then>
void sum_of(int64_t n, const Sum* partial, const Then& then) {
  launch(detail::total_sum<Sum, Then>, 1, kSumThreads, 0, n, partial, then);
}

/// Adds body(i, sum) over i of [0, n), then then(sum) by one thread of the device.
template <class Sum, class Body, class Then>
void ordered_sum(int64_t n, SumRoom<Sum>* room, const Body& body, const Then& then) {
  const int64_t blocks = (n + kSumThreads - 1) / kSumThreads;
  const auto launched = unsigned(blocks < 1 ? 1 : blocks > kSumBlocks ? kSumBlocks : blocks);
  launch(detail::ordered_sum_kernel<Sum, Body, Then>, launched, kSumThreads, 0, n, room, body,
         then);
}

}  // namespace elastogen::cuda
