// SPDX-License-Identifier: Apache-2.0
// EXT_meshopt_compression: buffer views that meshoptimizer packed.

#pragma once

#include "io/gltf_edit.hpp"

namespace elastogen {

/// Turns packed buffer views into plain ones. Before anything is allocated, every parameter is
/// checked against the extension's rules, the packed bytes that are there and the length of the
/// view. One byte of a stream holds at most 64 bytes of a vertex buffer, or three indices.
/// @throws Error (asset) naming the buffer view.
void decode_meshopt(GltfEdit& edit);

}  // namespace elastogen
