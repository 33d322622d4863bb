// SPDX-License-Identifier: Apache-2.0
// Sorts and prefix sums of whole numbers of the device, by CUB. The order of equal keys is kept, so
// every card and every run gives the result of core/parallel_sort.hpp and core/scan.hpp. Nothing
// allocates or waits; all runs on the stream of the thread.

#pragma once

#include "core/cuda/array.cuh"

namespace elastogen::cuda {

/// Work space of sorts and sums of at most `capacity` numbers.
class SortWork {
 public:
  /// @throws Error (resources) if the device has too little memory.
  explicit SortWork(int64_t capacity);

  int64_t capacity() const { return places_.size(); }
  const int32_t* places() const { return places_.data(); }
  DeviceArray<unsigned char>& temporary() { return temporary_; }

 private:
  DeviceArray<int32_t> places_;  // 0, 1, 2, ...
  DeviceArray<unsigned char> temporary_;
};

/// sorted[k] = keys[order[k]], ascending; equal keys in the order of their places.
/// @tparam Key   uint32_t or uint64_t.
/// @param keys   (n), not changed.
/// @param sorted, order  (n), none of them keys.
/// @param bits   the count of lowest bits of the keys, in which they differ.
/// @throws Error if n is more than the capacity.
template <class Key>
void sort_with_order(const Key* keys, int64_t n, Key* sorted, int32_t* order, SortWork& work,
                     int bits = 8 * int(sizeof(Key)));

/// sums[k] = values[0] + ... + values[k - 1], the sum of all at the end.
/// @tparam T     int32_t or int64_t.
/// @param values (n).
/// @param sums   (n + 1), not values.
/// @throws Error if n is more than the capacity.
template <class T>
void exclusive_sum(const T* values, int64_t n, T* sums, SortWork& work);

}  // namespace elastogen::cuda
