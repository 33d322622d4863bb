// SPDX-License-Identifier: Apache-2.0
// Reads glTF 2.0 (.glb, .gltf): triangle meshes and the node tree of the default scene.

#pragma once

#include "io/asset.hpp"
#include "io/read_options.hpp"

#include <string>

namespace elastogen {

/// Reads a glTF file. Asset::nodes are all nodes of the file in its order; nodes outside the
/// default scene show no mesh. A mesh's positions are its distinct POSITION accessors one after the
/// other, in order of first use by a triangle primitive. Strips and fans become triangles.
/// Compressed, quantized and skinned meshes are read as plain_gltf makes them. Other primitives,
/// morph targets and animations are left out with a finding.
/// @throws Error (asset) naming file and place: a broken file, as plain_gltf, unknown required
///         extensions, indices or byte ranges out of bounds, a cyclic node tree, files outside the
///         asset's folder.
Asset read_gltf(const std::string& path, const ReadOptions& options);
Asset read_gltf(const std::string& path);

}  // namespace elastogen
