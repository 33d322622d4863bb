// SPDX-License-Identifier: Apache-2.0
// STL to an Asset, positions in double precision and in the order of the file.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// Text and binary. A text gives a mesh for each name of a solid. Each facet has three positions of
/// its own in the file's order. A file whose size fits its facet count is binary, whatever its
/// header says.
/// @throws Error (asset) with the file and the place: fewer bytes than the facet count says, a
/// facet without three vertices.
Asset read_stl(const std::string& path);

/// Reads STL from memory; `path` is for messages.
Asset parse_stl(std::string_view bytes, const std::string& path);

}  // namespace elastogen
