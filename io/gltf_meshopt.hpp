// SPDX-License-Identifier: Apache-2.0
// EXT_meshopt_compression: buffer views whose bytes are packed by meshoptimizer.

#pragma once

#include "io/gltf_edit.hpp"

namespace elastogen {

/// Turns packed buffer views into plain ones. Every parameter is checked against the extension's
/// rules, the packed bytes that are there and the length of the view before anything is allocated;
/// no stream holds more than 64 bytes of a vertex buffer, or three indices, in one of its bytes.
/// @throws Error (asset) naming the buffer view.
void decode_meshopt(GltfEdit& edit);

}  // namespace elastogen
