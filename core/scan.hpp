// SPDX-License-Identifier: Apache-2.0
// Prefix sums of whole numbers; those of the device are in core/cuda/sort.cuh.

#pragma once

#include "core/parallel.hpp"

#include <numeric>
#include <type_traits>

namespace elastogen {

/// sums[k] = values[0] + ... + values[k - 1], the sum of all at the end.
/// @param values (n).
/// @param sums   (n + 1), not values.
template <class T>
void exclusive_sum(const T* values, int64_t n, T* sums) {
  static_assert(std::is_integral_v<T>);
  std::vector<T> before(size_t((n + kBlock - 1) / kBlock));
  for_blocks(n, [&](int64_t begin, int64_t end) {
    before[size_t(begin / kBlock)] = std::accumulate(values + begin, values + end, T(0));
  });
  std::exclusive_scan(before.begin(), before.end(), before.begin(), T(0));
  sums[0] = 0;
  for_blocks(n, [&](int64_t begin, int64_t end) {
    T sum = before[size_t(begin / kBlock)];
    for (int64_t k = begin; k < end; ++k) sums[k + 1] = sum += values[k];
  });
}

}  // namespace elastogen
