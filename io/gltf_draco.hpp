// SPDX-License-Identifier: Apache-2.0
// KHR_draco_mesh_compression: primitives with triangles and attributes that Draco packed.

#pragma once

#include "io/gltf_edit.hpp"

namespace elastogen {

/// Gives packed primitives plain accessors: 32-bit indices, attributes in the component type that
/// their accessors state, vertices and triangles in the order of the stream. Primitives with one
/// stream still share their accessors. The claims of a stream (triangles, vertices, attributes)
/// are compared with the accessors before the library allocates memory.
/// @throws Error (asset) naming mesh and primitive.
void decode_draco(GltfEdit& edit);

}  // namespace elastogen
