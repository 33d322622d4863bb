// SPDX-License-Identifier: Apache-2.0
// A sort on TBB. If no two elements are equivalent, or equivalent ones are equal, the order follows
// from the comparison alone and does not depend on the number of threads. The sort by keys of the
// device is in core/cuda/sort.cuh.

#pragma once

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>

namespace elastogen {

/// Sorts [begin, end) by `less`.
template <class Iterator, class Less = std::less<>>
void parallel_sort(Iterator begin, Iterator end, const Less& less = {}) {
#ifdef __SANITIZE_THREAD__
  std::sort(begin, end, less);  // as in core/parallel.hpp
#else
  tbb::parallel_sort(begin, end, less);
#endif
}

/// sorted[k] = keys[order[k]], ascending; equal keys in the order of their places.
/// @param keys  (n).
/// @param sorted, order  (n), none of them keys.
template <class Key>
void sort_with_order(const Key* keys, int64_t n, Key* sorted, int32_t* order) {
  std::iota(order, order + n, 0);
  parallel_sort(order, order + n, [=](int32_t a, int32_t b) {
    return keys[a] != keys[b] ? keys[a] < keys[b] : a < b;
  });
  for (int64_t k = 0; k < n; ++k) sorted[k] = keys[order[k]];
}

}  // namespace elastogen
