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

/// The sum over the threads of a block in a fixed order; thread 0 has it. `all` holds
/// kSumThreads Sums of shared memory.
template <class Sum>
__device__ inline Sum block_sum(const Sum& mine, Sum* all) {
  all[threadIdx.x] = mine;
  for (int half = kSumThreads / 2; half > 0; half /= 2) {
    __syncthreads();
    if (threadIdx.x < half) all[threadIdx.x].add(all[threadIdx.x + half]);
  }
  return all[0];
}

namespace detail {

template <class Sum, class Body>
__global__ void __launch_bounds__(kSumThreads) partial_sums(int64_t n, Sum* partial, Body body) {
  alignas(Sum) __shared__ unsigned char all[kSumThreads * sizeof(Sum)];
  Sum mine;
  for (int64_t i = int64_t(blockIdx.x) * kSumThreads + threadIdx.x; i < n;
       i += int64_t(kSumBlocks) * kSumThreads)
    body(i, mine);
  const Sum sum = block_sum(mine, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) partial[blockIdx.x] = sum;
}

template <class Sum, class Then>
__global__ void __launch_bounds__(kSumThreads) total_sum(int64_t n, const Sum* partial, Then then) {
  alignas(Sum) __shared__ unsigned char all[kSumThreads * sizeof(Sum)];
  Sum mine;
  for (int64_t k = threadIdx.x; k < n; k += kSumThreads) mine.add(partial[k]);
  const Sum sum = block_sum(mine, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) then(sum);
}

}  // namespace detail

/// then(sum of partial) by one thread of the device; a Sum has add(other).
template <class Sum, class Then>
void sum_of(int64_t n, const Sum* partial, const Then& then) {
  detail::total_sum<<<1, kSumThreads>>>(n, partial, then);
  check(cudaGetLastError());
}

/// Adds body(i, sum) over i of [0, n), then then(sum) by one thread of the device.
/// @param partial  kSumBlocks Sums.
template <class Sum, class Body, class Then>
void ordered_sum(int64_t n, Sum* partial, const Body& body, const Then& then) {
  detail::partial_sums<<<kSumBlocks, kSumThreads>>>(n, partial, body);
  check(cudaGetLastError());
  sum_of(kSumBlocks, partial, then);
}

}  // namespace elastogen::cuda
