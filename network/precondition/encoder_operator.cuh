// SPDX-License-Identifier: Apache-2.0
// The elastic operator at rest on the modes of the encoder (network/precondition/encoder_operator.hpp), made by
// the device from the tables of the potential.

#pragma once

#include "network/potential/incremental_potential_device.hpp"

#include <cuda_fp16.h>

#include <type_traits>
#include <vector>

namespace elastogen::cuda {

/// What modes are held in: those in float are numbers of half precision.
template <class T>
using ModeNumber = std::conditional_t<sizeof(T) == 4, __half, double>;

/// The list of all pieces' nodes of an encoder on the device.
template <class T>
struct DeviceModes {
  const ModeNumber<T>* modes;  ///< (entries, kModes)
  const int32_t* nodes;        ///< node of each entry, (entries)
  const int32_t* entry;        ///< entry of each node of the grid, -1: in no piece; (nodes)
};

/// A_r at rest of the entries [first, end), which are one connected piece: that of
/// reduced_rest_operator on the host, (3 kModes, 3 kModes), row 3 m + i mode m of component i; to
/// rounding in float64, for modes that are numbers of ModeNumber. The same bits on every run.
/// Waits for the device; not while room is only counted.
/// @param potential  its inertia must be there.
/// @throws Error (resources) where the device has no room.
template <class T>
std::vector<double> reduced_rest_operator(DevicePotential& potential, const DeviceModes<T>& modes,
                                          int32_t first, int32_t end);

/// The modes of pieces that a DeviceEncoder makes itself (network/precondition/encoder_modes.cuh), piece by
/// piece, for tests.
template <class T>
std::vector<ModeNumber<T>> modes_by_device(DevicePotential& potential,
                                           const std::vector<std::vector<int32_t>>& pieces);

}  // namespace elastogen::cuda
