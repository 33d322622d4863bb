// SPDX-License-Identifier: Apache-2.0
// STL to an Asset, positions in double precision and in the order of the file.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// Text and binary; a mesh for each name of a solid in a text, three positions a facet in the
/// file's order, nothing welded. A file whose size is what its facet count says is binary, whatever
/// its header.
/// @throws Error (asset) with the file and the place: fewer bytes than the facet count says, a
/// facet without three vertices.
Asset read_stl(const std::string& path);

/// The same from memory; `path` is for messages.
Asset parse_stl(std::string_view bytes, const std::string& path);

}  // namespace elastogen
