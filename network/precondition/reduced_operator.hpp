// SPDX-License-Identifier: Apache-2.0
// The elastic operator on the modes of a piece, A_r, and the matrices that the encoder
// (network/precondition/encoder.hpp) needs from it.

#pragma once

#include "network/precondition/encoder_modes.hpp"

#include <vector>

namespace elastogen {

inline constexpr int kReducedSize = 3 * kEncoderModes;  ///< row 3 m + i: mode m of component i

/// All matrices are (kReducedSize, kReducedSize).
struct ReducedOperator {
  static constexpr double kKnown = 0.8;  ///< s

  ReducedOperator() = default;
  explicit ReducedOperator(std::vector<double>&& at_rest);

  /// Sets inverse and correction for another A_r, e.g. one with contact.
  void invert(const std::vector<double>& A);
  /// The largest eigenvalue of A_r^-1 D_r at rest, to a few per cent from below; 1 or more.
  double softness() const;

  std::vector<double> rest;        ///< A_r at rest
  std::vector<double> inverse;     ///< of A_r
  std::vector<double> correction;  ///< A_r^-1 - s D_r^-1
};

}  // namespace elastogen
