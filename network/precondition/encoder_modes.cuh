// SPDX-License-Identifier: Apache-2.0
// The encoder's modes (network/precondition/encoder_modes.hpp), made on the device where they are used.

#pragma once

#include "core/cuda/array.cuh"
#include "network/precondition/encoder_operator.cuh"

namespace elastogen::cuda {

/// The modes of some pieces, whose nodes lie one after the other.
template <class T>
struct PieceModesOnDevice {
  std::vector<int32_t> first;         ///< entry of each piece, and their count
  DeviceArray<int32_t> nodes;         ///< of the entries
  DeviceArray<ModeNumber<T>> values;  ///< (entries, kModes), the bits of Encoder<T>'s
};

/// @param pieces  nodes of encoder_pieces.
/// @throws Error (resources) where the device has no room.
template <class T>
PieceModesOnDevice<T> make_modes(DevicePotential& potential,
                                 const std::vector<std::vector<int32_t>>& pieces);

}  // namespace elastogen::cuda
