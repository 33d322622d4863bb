// SPDX-License-Identifier: Apache-2.0
// The reader of each format, chosen by content, then by the name's ending.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Reads an asset (.obj .ply .stl .glb .gltf; others through io/child_reader.hpp) and checks it
/// (io/asset_check.hpp).
/// @throws Error (asset) for a missing or empty file, a format that is not read, and all that the
///         readers and the check refuse.
Asset read_asset(const std::string& path);

}  // namespace elastogen
