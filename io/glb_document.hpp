// SPDX-License-Identifier: Apache-2.0
// The GLB container, and the glTF document of an asset to which a writer adds an animation.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_source.hpp"

#include <string>
#include <vector>

namespace elastogen {

/// JSON with one buffer. Node i of the document is node i of the asset.
struct GlbDocument {
  std::string json;
  Bytes bin;
  std::vector<std::string> notes;  ///< what could not be kept
};

/// The document of an asset from a glTF file: the file's own, with buffers and images from beside
/// it embedded, made plain (io/plain_gltf.hpp). Animations and morph targets of simulated nodes are
/// removed (io/gltf_animations.hpp); the bytes of all other accessors and images stay as they are.
/// @throws Error (asset) as read_gltf_source and plain_gltf.
GlbDocument gltf_document(const Asset& asset);

/// A document for an asset from any other format: one mesh for each of the asset's, with its drawn
/// vertices in order. Positions are float32. If a mesh lies further from the origin than 100
/// times its size, they are relative to its centre, which goes into the node. PNG and JPEG textures
/// are embedded.
GlbDocument mesh_document(const Asset& asset);

/// MIME type of an image by its first bytes, "" if glTF does not allow it.
std::string image_type(const Bytes& image);

/// Appends bytes at a multiple of four; returns their offset.
uint64_t append_bytes(Bytes& bin, const void* data, size_t size);

/// Writes a GLB file under a temporary name and renames it.
/// @throws Error (resources) if it would be larger than the 4 GiB of the format or the disk is
/// full.
void write_glb(const std::string& path, const std::string& json, const Bytes& bin);

}  // namespace elastogen
