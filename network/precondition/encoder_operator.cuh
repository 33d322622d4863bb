// SPDX-License-Identifier: Apache-2.0
// The elastic operator at rest on the modes of the encoder (encoder_operator.hpp), made by
// the device from the tables of the potential.

#pragma once

#include "network/potential/incremental_potential_device.hpp"

#include <cuda_fp16.h>

#include <type_traits>
#include <vector>

namespace elastogen::cuda {

/// Type in which modes are stored: half precision for an encoder in float.
template <class T>
using ModeNumber = std::conditional_t<sizeof(T) == 4, __half, double>;

/// The list of all pieces' nodes of an encoder on the device.
template <class T>
struct DeviceModes {
  const ModeNumber<T>* modes;  ///< (entries, kModes)
  const int32_t* nodes;        ///< node of each entry, (entries)
  const int32_t* entry;        ///< entry of each node of the grid, -1: in no piece; (nodes)
};

/// A_r at rest of the entries [first, end), which are one connected piece: (3 kModes, 3 kModes),
/// row 3 m + i for mode m of component i. It equals reduced_rest_operator of the host to rounding
/// in float64, for modes that ModeNumber represents exactly. Every run gives the same bits. Waits
/// for the device; must not be called while memory is only counted.
/// @param potential  its inertia must be there.
/// @throws Error (resources) if the device has too little memory.
template <class T>
std::vector<double> reduced_rest_operator(DevicePotential& potential, const DeviceModes<T>& modes,
                                          int32_t first, int32_t end);

/// The modes that a DeviceEncoder makes of pieces (encoder_modes.cuh), piece by piece; for
/// tests.
template <class T>
std::vector<ModeNumber<T>> modes_by_device(DevicePotential& potential,
                                           const std::vector<std::vector<int32_t>>& pieces);

}  // namespace elastogen::cuda
