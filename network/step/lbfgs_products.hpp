// SPDX-License-Identifier: Apache-2.0
// The two loops of L-BFGS (lbfgs.hpp) on the products of its vectors alone, so that all
// pairs are read once before and once after the first matrix B (Byrd, Nocedal, Schnabel 1994):
//
//     q = g - sum_k alpha_k y_k,     d = B q + sum_k c_k s_k,
//
//     alpha_k = (s_k.g - sum_{j newer than k} alpha_j s_k.y_j) / s_k.y_k,
//     c_k = alpha_k - (y_k.B q + sum_{j older than k} c_j s_j.y_k) / s_k.y_k.

#pragma once

#include "core/base.hpp"

#include <cmath>

namespace elastogen {

/// Products of the pairs, the newest first, with each other and with the gradient g.
struct LbfgsProducts {
  static constexpr int kPairs = 5, kOlder = kPairs - 1;

  /// Products of a new pair s, y, and of the gradient g at its end.
  struct Newest {
    double sy, ss, yy, sg;
    double older_g[kOlder], older_y[kOlder];  ///< s_k.g and s_k.y of the earlier pairs
  };

  /// Count of the pairs that stay when the next one comes.
  ELASTOGEN_HD int older() const { return count < kOlder ? count : kOlder; }

  /// Adds the newest pair if its curvature s.y is safely positive; the gradient becomes that at its
  /// end in any case. Returns whether the pair is part of the history.
  bool take(const Newest& pair) {
    const int left = older();
    const bool kept = pair.sy > 1e-10 * std::sqrt(pair.ss * pair.yy) && pair.sy != 0;
    const int shift = kept ? 1 : 0;
    for (int k = left - 1; k >= 0; --k) {
      for (int j = k; j >= 0; --j) sy[k + shift][j + shift] = sy[k][j];
      sg[k + shift] = pair.older_g[k];
      if (kept) sy[k + 1][0] = pair.older_y[k];
    }
    if (kept) sy[0][0] = pair.sy, sg[0] = pair.sg;
    count = left + shift;
    return kept;
  }

  /// alpha of the first loop, 0 beyond count.
  void first_loop(double alpha[kPairs]) const {
    for (int k = 0; k < kPairs; ++k) {
      alpha[k] = 0;
      if (k >= count) continue;
      double sum = sg[k];
      for (int j = 0; j < k; ++j) sum -= alpha[j] * sy[k][j];
      alpha[k] = sum / sy[k][k];
    }
  }

  /// c of the second loop, 0 beyond count, from y_k.B q.
  ELASTOGEN_HD void second_loop(const double alpha[kPairs], const double yd[kPairs],
                                double c[kPairs]) const {
    // all k and j, so that a device keeps c in registers
    for (int k = kPairs - 1; k >= 0; --k) {
      double sum = yd[k];
      for (int j = kPairs - 1; j > k; --j) sum += j < count ? c[j] * sy[j][k] : 0;
      c[k] = k < count ? alpha[k] - sum / sy[k][k] : 0;
    }
  }

  int count = 0;
  double sy[kPairs][kPairs] = {};  ///< s_k.y_j, j <= k
  double sg[kPairs] = {};          ///< s_k.g
};

}  // namespace elastogen
