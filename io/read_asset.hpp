// SPDX-License-Identifier: Apache-2.0
// Reads an asset with the reader of its format, which content decides, then the name's ending.

#pragma once

#include "io/asset.hpp"
#include "io/read_options.hpp"

namespace elastogen {

/// Endings of the formats that are read, as messages and the help of the command list them.
inline constexpr const char* kReadFormats =
    ".obj .ply .stl .glb .gltf .off .fbx .dae .3ds .x .ac .vdb .xyz .asc .pts .pcd .las .splat "
    ".spz";

/// Reads an asset, some formats through io/child_reader.hpp, and checks it (io/asset_check.hpp).
/// @throws Error (asset) for a missing or empty file, a format that is not read (with advice if
///         there is any), and everything that the readers and the check refuse.
Asset read_asset(const std::string& path, const ReadOptions& options = {});

}  // namespace elastogen
