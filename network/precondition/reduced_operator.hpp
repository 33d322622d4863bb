// SPDX-License-Identifier: Apache-2.0
// The elastic operator on the modes of a piece, A_r, and the matrices that the encoder
// (network/precondition/encoder.hpp) needs from it.

#pragma once

#include "network/precondition/encoder_modes.hpp"

#include <vector>

namespace elastogen {

inline constexpr int kReducedSize = 3 * kEncoderModes;  ///< row 3 m + i: mode m of component i

/// s of the encoder, the share of D_r^-1 that multigrid is taken to know: 0.8, less for materials
/// close to incompressible, whose scalar operators multigrid solves less well. Measured limits of
/// definiteness: 0.94 at nu 0.49, 0.85 at 0.495, 0.66 at 0.499 (preconditioner_test.cpp).
double known_share(const Scene& scene);

/// All matrices are (kReducedSize, kReducedSize).
struct ReducedOperator {
  ReducedOperator() = default;
  /// @param share  s.
  ReducedOperator(std::vector<double>&& at_rest, double share);

  /// Sets inverse and correction for another A_r, e.g. one with contact.
  void invert(const std::vector<double>& A);
  /// The largest eigenvalue of A_r^-1 D_r at rest, to a few per cent from below; 1 or more.
  double softness() const;

  double known = 0;                ///< s
  std::vector<double> rest;        ///< A_r at rest
  std::vector<double> inverse;     ///< of A_r
  std::vector<double> correction;  ///< A_r^-1 - s D_r^-1
};

}  // namespace elastogen
