// SPDX-License-Identifier: Apache-2.0
// OFF meshes (Geomview's object file format) to an Asset.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// Text with one vertex or face a line, # begins a comment: the keyword [ST][C][N]OFF, counts of
/// vertices, faces and edges behind it or on the next line; x y z, with N a normal, with C a colour
/// of three or four numbers, with ST coordinates of a texture; faces of any number of corners with
/// a colour of three or four numbers. Colours are sRGB of 0 ... 255, or of 0 ... 1 where no number
/// is larger, for vertices and faces apart.
/// @throws Error (asset) with file and line: another keyword, 4OFF, nOFF and binary files, counts
///         beyond the bytes that follow, an index out of range, a line with too few numbers.
Asset read_off(const std::string& path);

/// Reads OFF from memory; `path` is for messages.
Asset parse_off(std::string_view bytes, const std::string& path);

}  // namespace elastogen
