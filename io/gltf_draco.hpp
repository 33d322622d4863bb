// SPDX-License-Identifier: Apache-2.0
// KHR_draco_mesh_compression: primitives whose triangles and attributes are packed by Draco.

#pragma once

#include "io/gltf_edit.hpp"

namespace elastogen {

/// Gives packed primitives plain accessors: 32-bit indices, attributes in the component type that
/// their accessors state, vertices and triangles in the order of the stream. Two primitives with
/// the same stream share what they shared before. What a stream claims (triangles, vertices,
/// attributes) is compared with the accessors before the library allocates for it.
/// @throws Error (asset) naming mesh and primitive.
void decode_draco(GltfEdit& edit);

}  // namespace elastogen
