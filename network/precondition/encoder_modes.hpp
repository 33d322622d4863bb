// SPDX-License-Identifier: Apache-2.0
// The modes of the encoder (encoder.hpp) at a node, and the pieces that have them.

#pragma once

#include "network/precondition/smooth_modes.hpp"

namespace elastogen {

inline constexpr int kEncoderCosines = 18;
inline constexpr int kEncoderModes = kEncoderCosines + 3;  ///< of a displacement component

/// Nodes of the largest connected pieces, those that have an encoder; the largest first, ties by
/// number.
std::vector<std::vector<int32_t>> encoder_pieces(const VoxelGrid& grid);

/// Data that the modes of a piece are computed from.
struct ModeShape {
  CosineTables cosines;
  double lower[3], upper[3];  ///< of its nodes at rest [m]
  double size;                ///< longest of the box's edges [m]
};

/// @param cosines  must outlive it.
ModeShape mode_shape(const Box& box, const PlaneCosines& cosines);

/// A mode's value in the digits that are stored: in float those of half precision, as on a card.
/// All uses of a mode agree in these digits, so that the rounded mode is as good as the exact one.
ELASTOGEN_HD inline float kept_value(double mode, float) {
  // Veltkamp's splitting gives the 11 leading bits, if no operations are fused
  const float x = float(mode), c = x * 8193;
  return c - (c - x);
}
ELASTOGEN_HD inline double kept_value(double mode, double) {
  return mode;
}

/// That of a node that follows others. Weighted sums may be as small as they like: below the least
/// normal number of half precision they are left out, so that all uses agree there too.
ELASTOGEN_HD inline float kept_sum(double mode, float) {
  return std::abs(mode) < 0x1p-14 ? 0 : kept_value(mode, float{});
}
ELASTOGEN_HD inline double kept_sum(double mode, double) {
  return mode;
}

/// Calls put(m, value) for the modes at a node.
/// @param distance  to the nearest pin [m]
/// @param at        lattice coordinates
/// @param X         position at rest [m]
template <class T, class Put>
ELASTOGEN_HD inline void for_modes(const ModeShape& shape, double distance, const int32_t at[3],
                                   const double X[3], const Put& put) {
  const double factor = distance / (distance + shape.size / 8);
  for (int w = 0; w < kEncoderCosines; ++w) put(w, kept_value(factor * shape.cosines(w, at), T{}));
  for (int i = 0; i < 3; ++i)
    put(kEncoderCosines + i,
        kept_value(factor * (2 * X[i] - shape.lower[i] - shape.upper[i]) / shape.size, T{}));
}

}  // namespace elastogen
