// SPDX-License-Identifier: Apache-2.0
// Access to a few numbers of an array at once, so that a thread has more bytes in flight.

#pragma once

#include "core/cuda/reduce.cuh"

namespace elastogen::cuda {

/// Numbers that are moved by one instruction, 16 bytes at most.
template <int kWidth, class T>
struct alignas(kWidth * sizeof(T)) WidePart {
  T value[kWidth];
};

/// The numbers [first, first + kWidth) of arrays.
template <int kWidth>
struct Wide {
  static constexpr int kCount = kWidth;
  int64_t first;

  template <class T>
  __device__ void load(const T* from, T to[kWidth]) const {
#pragma unroll
    for (int k = 0; k < kWidth; k += kAtOnce<T>) {
      const auto part = *reinterpret_cast<const Part<T>*>(from + first + k);
#pragma unroll
      for (int j = 0; j < kAtOnce<T>; ++j) to[k + j] = part.value[j];
    }
  }

  template <class T>
  __device__ void store(const T from[kWidth], T* to) const {
#pragma unroll
    for (int k = 0; k < kWidth; k += kAtOnce<T>) {
      Part<T> part;
#pragma unroll
      for (int j = 0; j < kAtOnce<T>; ++j) part.value[j] = from[k + j];
      *reinterpret_cast<Part<T>*>(to + first + k) = part;
    }
  }

 private:
  template <class T>
  static constexpr int kAtOnce = kWidth * sizeof(T) <= 16 ? kWidth : int(16 / sizeof(T));
  template <class T>
  using Part = WidePart<kAtOnce<T>, T>;
};

namespace detail {

/// Count of items for n numbers: kWidth numbers each, the rest one by one.
template <int kWidth>
constexpr int64_t wide_items(int64_t n) {
  return n / kWidth + n % kWidth;
}
template <int kWidth, class Body>
__device__ inline void at_wide_item(int64_t item, int64_t n, const Body& body) {
  const int64_t whole = n / kWidth;
  if (item < whole)
    body(Wide<kWidth>{kWidth * item});
  else
    body(Wide<1>{(kWidth - 1) * whole + item});
}

}  // namespace detail

/// Calls body(at) for all numbers of [0, n): `at` is a Wide<kWidth>, or a Wide<1> at the end.
template <int kWidth, class Body>
void for_each_wide(int64_t n, const Body& body) {
  cuda::for_each(detail::wide_items<kWidth>(n),
                 [=] __device__(int64_t item) { detail::at_wide_item<kWidth>(item, n, body); });
}

/// ordered_sum() of body(at, sum).
template <int kWidth, class Sum, class Body, class Then>
void ordered_wide_sum(int64_t n, SumScratch<Sum>* scratch, const Body& body, const Then& then) {
  ordered_sum(
      detail::wide_items<kWidth>(n), scratch,
      [=] __device__(int64_t item, Sum & sum) {
        detail::at_wide_item<kWidth>(item, n, [&](const auto& at) { body(at, sum); });
      },
      then);
}

}  // namespace elastogen::cuda
