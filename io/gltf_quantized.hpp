// SPDX-License-Identifier: Apache-2.0
// KHR_mesh_quantization: integers where glTF itself asks for floats.

#pragma once

#include "io/gltf_edit.hpp"

namespace elastogen {

/// Makes POSITION, NORMAL and TANGENT of integers, and TEXCOORDs of integers that glTF itself does
/// not allow, accessors of floats with the same values, normalised ones between -1 and 1. They keep
/// their index, so what shared them still does. POSITIONs whose values were decoded get bounds.
/// @throws Error (asset) as accessor_values.
void widen_quantized(GltfEdit& edit);

}  // namespace elastogen
