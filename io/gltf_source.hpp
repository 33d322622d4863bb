// SPDX-License-Identifier: Apache-2.0
// The container of a glTF asset: its JSON text and the bytes that the text refers to. The file is
// not trusted: every length is checked against the bytes that are there, and files beside it are
// opened only within its own folder.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace elastogen {

using Bytes = std::vector<uint8_t>;

/// A glTF document: JSON of bounded depth and one block of bytes for each of its buffers.
struct GltfSource {
  std::string path;
  std::string json;
  std::vector<Bytes> buffers;
};

/// Reads a .glb or .gltf file and resolves its buffers (GLB chunk, data URI, file beside it).
/// @throws Error (asset) on a broken container, JSON that is malformed or nested deeper than 128
///         levels, a buffer that is missing or shorter than stated, or a URI that leaves the
///         folder.
GltfSource read_gltf_source(const std::string& path);

/// Path of the file that a URI names within the folder of `asset_path`; "" if there is no such file
/// or a link leaves the folder.
/// @param what  names the place for messages, e.g. "images[2]".
/// @throws Error (asset) on a URI with a scheme, an absolute path, or "..".
std::string resolve_gltf_uri(const std::string& asset_path, const std::string& uri,
                             const std::string& what);

/// Bytes of a data URI or of the file that resolve_gltf_uri finds.
/// @throws Error (asset) as resolve_gltf_uri, and on a missing file or invalid base64.
Bytes read_gltf_uri(const std::string& asset_path, const std::string& uri, const std::string& what);

/// True for "data:...".
bool is_data_uri(const std::string& uri);

}  // namespace elastogen
