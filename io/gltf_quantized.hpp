// SPDX-License-Identifier: Apache-2.0
// KHR_mesh_quantization: integers where glTF itself requires floats.

#pragma once

#include "io/gltf_edit.hpp"

namespace elastogen {

/// Turns POSITION, NORMAL and TANGENT of integers, and TEXCOORDs of integers that glTF itself does
/// not allow, into accessors of floats with the same values; normalised integers become -1 ... 1.
/// Accessors keep their index, so they stay shared. POSITIONs that were decoded get bounds.
/// @throws Error (asset) as accessor_values.
void widen_quantized(GltfEdit& edit);

}  // namespace elastogen
