// SPDX-License-Identifier: Apache-2.0
// The geometry part of a glTF document, read by tinygltf.

#pragma once

#include "io/gltf_source.hpp"

namespace tinygltf {
class Model;
}

namespace elastogen {

/// Fills scenes, nodes, meshes, accessors, buffer views and materials of a model. tinygltf treats
/// fields of a wrong type as absent, narrows integers and recurses. It therefore gets only fields
/// that have been checked: every index and size is a non-negative integer below 2^31 (byte offsets
/// and lengths: 2^53), lists hold objects, and extras, extensions, buffers and images are left out.
/// Indices are not yet compared with the lists that they index.
/// @throws Error (asset) naming the field.
void read_gltf_model(const GltfSource& source, tinygltf::Model& model);

/// Only checks, as read_gltf_model does, for documents whose accessors are still packed.
/// @throws Error (asset) naming the field.
void check_gltf_types(const GltfSource& source);

}  // namespace elastogen
