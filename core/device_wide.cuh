// SPDX-License-Identifier: Apache-2.0
// A few numbers of an array at once, so that a thread has more bytes on their way.

#pragma once

#include <cstdint>

namespace elastogen::cuda {

/// Numbers that are moved by one instruction, 16 bytes at most.
template <int kWidth, class T>
struct alignas(kWidth * sizeof(T)) WidePart {
  T value[kWidth];
};

/// As many numbers as kWidth, or what is left of them.
template <int kWidth>
struct Wide {
  int64_t first;
  int count;

  /// The part-th of n numbers.
  __device__ Wide(int64_t part, int64_t n)
      : first(kWidth * part), count(n - first < kWidth ? int(n - first) : kWidth) {}

  /// 0 where there are no numbers left.
  template <class T>
  __device__ void load(const T* from, T to[kWidth]) const {
    if (count == kWidth) {
      for (int k = 0; k < kWidth; k += kAtOnce<T>) {
        const auto part = *reinterpret_cast<const Part<T>*>(from + first + k);
        for (int j = 0; j < kAtOnce<T>; ++j) to[k + j] = part.value[j];
      }
      return;
    }
    for (int k = 0; k < kWidth; ++k) to[k] = k < count ? from[first + k] : T(0);
  }

  template <class T>
  __device__ void store(const T from[kWidth], T* to) const {
    if (count == kWidth) {
      for (int k = 0; k < kWidth; k += kAtOnce<T>) {
        Part<T> part;
        for (int j = 0; j < kAtOnce<T>; ++j) part.value[j] = from[k + j];
        *reinterpret_cast<Part<T>*>(to + first + k) = part;
      }
      return;
    }
    for (int k = 0; k < count; ++k) to[first + k] = from[k];
  }

  static constexpr int64_t parts(int64_t n) { return (n + kWidth - 1) / kWidth; }

 private:
  template <class T>
  static constexpr int kAtOnce = kWidth * sizeof(T) <= 16 ? kWidth : int(16 / sizeof(T));
  template <class T>
  using Part = WidePart<kAtOnce<T>, T>;
};

}  // namespace elastogen::cuda
