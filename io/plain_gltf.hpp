// SPDX-License-Identifier: Apache-2.0
// Makes a glTF document plain: later steps see no compressed, quantized, skinned, morphed or
// instanced meshes. Every run gives the same plain document for a file.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_source.hpp"

#include <vector>

namespace elastogen {

/// The document without KHR_draco_mesh_compression, EXT_meshopt_compression, KHR_mesh_quantization,
/// EXT_mesh_gpu_instancing (io/gltf_instancing.hpp) and skins, with meshes in the shape of their
/// morph weights (io/gltf_morph.hpp). Added bytes lie in one further buffer. Vertices and triangles
/// keep the order of the decoded data. Skinned meshes stand in the pose of their joints (finding
/// "skins"), on nodes of their own at the root, behind the document's nodes. The roots of a scene
/// have no parent (finding "scene-roots"): a named root below another named one is no root, any
/// other is cut from its parent. A document without any of these is returned unchanged.
/// @throws Error (asset) as check_gltf_types, gltf_nodes, accessor_values; naming mesh and
///         primitive or buffer view where compressed data are broken, do not fit what the document
///         states, or would fill more than 4 GiB; on joints and weights that are out of range.
GltfSource plain_gltf(GltfSource source, std::vector<Finding>& findings);

}  // namespace elastogen
