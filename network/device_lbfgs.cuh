// SPDX-License-Identifier: Apache-2.0
// L-BFGS on the device, on products of its vectors (network/lbfgs_products.hpp): the pairs, and
// what an iteration makes of them and of the gradient.

#pragma once

#include "core/device_array.cuh"
#include "network/lbfgs_products.hpp"

namespace elastogen::cuda {

inline constexpr int kPairs = LbfgsProducts::kPairs, kOlder = LbfgsProducts::kOlder;

/// What an iteration tells the host.
struct Numbers {
  double slope;     ///< Phi' along the step, at its start
  double gradient;  ///< |g|^2 at the trial
  LbfgsProducts::Newest pair;
};

struct FirstLoop {
  double alpha[kPairs];
};

/// The vectors of the pairs, the newest first.
struct PairViews {
  const float *s[kPairs], *y[kPairs];
  int count;
};

/// The pairs in float, whatever the iteration is in: what the rounding takes from them is far below
/// what a direction is good for. The step that is tried lies where its s will be.
struct Pairs {
  explicit Pairs(int64_t n) {
    for (int k = 0; k <= kPairs; ++k) s.emplace_back(n);
    for (int k = 0; k < kPairs; ++k) y.emplace_back(n);
  }

  PairViews views() const {
    PairViews list{{}, {}, products.count};
    for (int k = 0; k < kPairs; ++k) {
      list.s[k] = s[size_t((next_s + kPairs - k) % (kPairs + 1))].data();
      list.y[k] = y[size_t((next_y + kPairs - 1 - k) % kPairs)].data();
    }
    return list;
  }
  float* step() { return s[size_t(next_s)].data(); }
  float* next_difference() { return y[size_t(next_y)].data(); }
  void take(const LbfgsProducts::Newest& pair) {
    if (!products.take(pair)) return;
    next_s = (next_s + 1) % (kPairs + 1);
    next_y = (next_y + 1) % kPairs;
  }

  std::vector<DeviceArray<float>> s, y;  // rings of kPairs + 1 and of kPairs
  LbfgsProducts products;
  int next_s = 0, next_y = 0;
};

}  // namespace elastogen::cuda
