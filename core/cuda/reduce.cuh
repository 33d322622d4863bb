// SPDX-License-Identifier: Apache-2.0
// Sums over numbers of the device in float64 and in an order that never changes, which stay on the
// device: every run on a card gives the same bits, without a round trip to the host.

#pragma once

#include "core/cuda/array.cuh"

namespace elastogen::cuda {

/// K sums that are formed together.
template <int K>
struct Sums {
  double value[K] = {};
  __device__ void add(const Sums& other) {
    for (int k = 0; k < K; ++k) value[k] += other.value[k];
  }
};

inline constexpr int kSumThreads = 256, kSumBlocks = 512;

inline constexpr int kSumWarps = kSumThreads / 32;

/// The sum of the lane `step` above in the warp.
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

namespace detail {

/// Steps of the sum below: a lane exchanges kWidth numbers with the lane kStep away.
template <int kWidth, int kStep, int kNumbers>
__device__ inline void share_numbers(double (&value)[kNumbers], int lane, int& number) {
  if constexpr (kWidth > 0) {
    const bool upper = lane & kStep;
    if (upper) number += kWidth;
#pragma unroll
    for (int k = 0; k < kWidth; ++k) {
      const double given = upper ? value[k] : value[k + kWidth];
      const double kept = upper ? value[k + kWidth] : value[k];
      value[k] = kept + __shfl_xor_sync(~0u, given, kStep);
    }
    share_numbers<kWidth / 2, kStep / 2>(value, lane, number);
  }
}

}  // namespace detail

/// block_sum of many sums: at each step a lane gives half of its numbers to its partner and gets
/// the partner's other half, until it has one number, which a few lanes share.
template <int K>
__device__ inline Sums<K> block_sum(const Sums<K>& mine, Sums<K>* all) {
  static_assert(K <= 16);
  constexpr int kNumbers = K > 8 ? 16 : K > 4 ? 8 : K > 2 ? 4 : K;
  const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
  double value[kNumbers];
#pragma unroll
  for (int k = 0; k < kNumbers; ++k) value[k] = k < K ? mine.value[k] : 0;
  int number = 0;
  detail::share_numbers<kNumbers / 2, 16>(value, lane, number);
  constexpr int kApart = 32 / kNumbers;  // lanes that have different numbers
#pragma unroll
  for (int step = kApart / 2; step > 0; step /= 2) value[0] += __shfl_xor_sync(~0u, value[0], step);
  if (lane % kApart == 0 && number < K) all[warp].value[number] = value[0];
  __syncthreads();
  // the first warp adds the warps
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

/// Blocks on a multiprocessor, by the registers that a sum needs, and most blocks of a sum.
template <class Sum>
inline constexpr int kSumResident = sizeof(Sum) > 8 * sizeof(double) ? 2 : 4;
template <class Sum>
inline constexpr int kMostSumBlocks = kSumResident<Sum> == 2 ? kSumBlocks / 2 : kSumBlocks;

/// Work space of a sum on the device; 0 at first, as a new DeviceArray is.
template <class Sum>
class SumScratch {
 public:
  /// Stores the sum of block k word by word, so that neighbouring threads read neighbouring words.
  __device__ void put(int64_t k, const Sum& sum) {
    const Words words = __builtin_bit_cast(Words, sum);
#pragma unroll
    for (int w = 0; w < kWords; ++w) words_[w][k] = words.word[w];
  }
  __device__ Sum get(int64_t k) const {
    Words words;
#pragma unroll
    for (int w = 0; w < kWords; ++w) words.word[w] = __ldcg(&words_[w][k]);
    return __builtin_bit_cast(Sum, words);
  }
  /// Whether this block, whose sum is stored, is the last of all.
  __device__ bool is_last() {
    __threadfence();
    const bool last = atomicInc(&done_, gridDim.x - 1) == gridDim.x - 1;  // and back to 0
    __threadfence();
    return last;
  }

 private:
  static constexpr int kWords = sizeof(Sum) / sizeof(uint64_t);
  static_assert(sizeof(Sum) % sizeof(uint64_t) == 0);
  struct Words {
    uint64_t word[kWords];
  };

  uint64_t words_[kWords][kSumBlocks];
  unsigned done_;  // blocks; 0 between the launches
};

namespace detail {

/// The sum of n numbers of get(k) by a block; each thread adds every kSumThreads-th.
template <class Sum, class Get>
__device__ inline Sum sum_of_partials(int64_t n, const Get& get, Sum* all) {
  Sum mine;
  for (int64_t k = threadIdx.x; k < n; k += kSumThreads) mine.add(get(k));
  return block_sum(mine, all);
}

/// Each thread adds its bodies, each block its threads, and the block that ends last all blocks in
/// their order. Which block that is does not matter.
template <class Sum, class Body, class Then>
__global__ void __launch_bounds__(kSumThreads, kSumResident<Sum>)
    ordered_sum_kernel(int64_t n, SumScratch<Sum>* scratch, Body body, Then then) {
  alignas(Sum) __shared__ unsigned char all[kSumWarps * sizeof(Sum)];
  __shared__ bool last;
  begin_kernel();
  Sum mine;
  for (int64_t i = int64_t(blockIdx.x) * kSumThreads + threadIdx.x; i < n;
       i += int64_t(gridDim.x) * kSumThreads)
    body(i, mine);
  const Sum of_block = block_sum(mine, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) {
    scratch->put(blockIdx.x, of_block);
    last = scratch->is_last();
  }
  __syncthreads();
  if (!last) return;
  const Sum sum = sum_of_partials(
      gridDim.x, [&](int64_t k) { return scratch->get(k); }, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) then(sum);
}

}  // namespace detail

/// Adds body(i, sum) over [0, n), then one thread calls then(sum); a Sum has add(other).
template <class Sum, class Body, class Then>
void ordered_sum(int64_t n, SumScratch<Sum>* scratch, const Body& body, const Then& then) {
  const int64_t blocks = (n + kSumThreads - 1) / kSumThreads;
  constexpr int kMost = kMostSumBlocks<Sum>;
  const auto launched = unsigned(blocks < 1 ? 1 : blocks > kMost ? kMost : blocks);
  launch(detail::ordered_sum_kernel<Sum, Body, Then>, launched, kSumThreads, 0, n, scratch, body,
         then);
}

}  // namespace elastogen::cuda
