// SPDX-License-Identifier: Apache-2.0
// L-BFGS on the device, by products of its vectors (lbfgs_products.hpp): the stored pairs,
// and the numbers that an iteration finds from them and the gradient.

#pragma once

#include "core/cuda/array.cuh"
#include "network/step/lbfgs_products.hpp"

#include <cuda_bf16.h>

namespace elastogen::cuda {

inline constexpr int kPairs = LbfgsProducts::kPairs, kOlder = LbfgsProducts::kOlder;

/// Numbers of an iteration that the host reads.
struct Numbers {
  double slope;             ///< Phi' along the step, at its start
  double trial_slope;       ///< Phi' along the step, at the trial
  double gradient;          ///< |g|^2 at the trial
  double of_pairs[kPairs];  ///< s_k.g where an iteration begins
  LbfgsProducts::Newest pair;
};

struct FirstLoop {
  double alpha[kPairs];
};

/// Type of the pairs' vectors: the range of float, 8 binary digits.
using PairNumber = __nv_bfloat16;

/// The vectors of the pairs, the newest first.
struct PairViews {
  const PairNumber *s[kPairs], *y[kPairs];
  int count;
};

/// The pairs, and the step that is tried. All products use the pairs as they are stored, so
/// rounding leaves the matrix symmetric and positive definite. Iterations are as many as with float
/// (docs/benchmarks.md), at half of its bytes.
struct Pairs {
  explicit Pairs(int64_t n) : step(n) {
    for (int k = 0; k < kPairs; ++k) s.emplace_back(n), y.emplace_back(n);
  }

  PairViews views() const {
    PairViews list{{}, {}, products.count};
    for (int k = 0; k < kPairs; ++k) {
      const auto place = size_t((next + kPairs - 1 - k) % kPairs);
      list.s[k] = s[place].data(), list.y[k] = y[place].data();
    }
    return list;
  }
  /// Memory of the next pair, which replaces the oldest pair of a full history.
  PairNumber* next_s() { return s[size_t(next)].data(); }
  PairNumber* next_y() { return y[size_t(next)].data(); }
  void take(const LbfgsProducts::Newest& pair) {
    if (products.take(pair)) next = (next + 1) % kPairs;
  }

  DeviceArray<float> step;
  std::vector<DeviceArray<PairNumber>> s, y;  // rings
  LbfgsProducts products;
  int next = 0;
};

}  // namespace elastogen::cuda
