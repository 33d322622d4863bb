// SPDX-License-Identifier: Apache-2.0
// The encoder's modes (network/precondition/encoder_modes.hpp), made on the device.

#pragma once

#include "core/cuda/array.cuh"
#include "network/precondition/encoder_operator.cuh"

namespace elastogen::cuda {

/// The modes of some pieces, whose nodes lie one after the other.
template <class T>
struct PieceModesOnDevice {
  std::vector<int32_t> first;         ///< first entry of each piece, then the count of entries
  DeviceArray<int32_t> nodes;         ///< node of each entry
  DeviceArray<ModeNumber<T>> values;  ///< (entries, kModes), those of Encoder<T> bit by bit
};

/// @param pieces  nodes of encoder_pieces.
/// @throws Error (resources) if the device has too little memory.
template <class T>
PieceModesOnDevice<T> make_modes(DevicePotential& potential,
                                 const std::vector<std::vector<int32_t>>& pieces);

}  // namespace elastogen::cuda
