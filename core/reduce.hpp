// SPDX-License-Identifier: Apache-2.0
// Sums and vector updates over nodal arrays: float64 sums in a fixed order.

#pragma once

#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

/// sum_i a_i b_i in float64.
template <class T>
double dot(const T* a, const T* b, int64_t n) {
  return ordered_sum(n, [=](int64_t begin, int64_t end) {
    // eight running sums, so that the loop is not one chain of additions
    double sum[8] = {};
    int64_t i = begin;
    for (; i + 8 <= end; i += 8)
      for (int k = 0; k < 8; ++k) sum[k] += double(a[i + k]) * double(b[i + k]);
    for (; i < end; ++i) sum[0] += double(a[i]) * double(b[i]);
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
  });
}

/// The largest value(i) of [0, n), 0 where all are below.
template <class Value>
double largest(int64_t n, const Value& value) {
  std::vector<double> found(size_t((n + kBlock - 1) / kBlock));
  for_blocks(n, [&](int64_t begin, int64_t end) {
    double most = 0;
    for (int64_t i = begin; i < end; ++i) most = std::max(most, value(i));
    found[size_t(begin / kBlock)] = most;
  });
  return found.empty() ? 0 : *std::max_element(found.begin(), found.end());
}

template <class T>
double norm(const T* a, int64_t n) {
  return std::sqrt(dot(a, a, n));
}

/// Whether all numbers are finite.
inline bool all_finite(const double* values, int64_t n) {
  return ordered_sum(n, [=](int64_t begin, int64_t end) {
           return double(std::count_if(values + begin, values + end,
                                       [](double v) { return !std::isfinite(v); }));
         }) == 0;
}

/// y += alpha x
template <class T>
void add_scaled(T alpha, const T* x, T* y, int64_t n) {
  for_blocks(n, [=](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) y[i] += alpha * x[i];
  });
}

}  // namespace elastogen
