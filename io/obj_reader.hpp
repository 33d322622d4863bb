// SPDX-License-Identifier: Apache-2.0
// OBJ to an Asset, positions in double precision and in the order of the file.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// A node and a mesh for each object and group (io/obj_nodes.hpp) that has faces; a file with one
/// of them gives one mesh with every position. Positions keep the file's order, one group a
/// material. Faces may have any number of corners (io/polygon.hpp), indices may be negative, lines
/// continued. Colours behind positions are sRGB. Materials come from the MTL files beneath the
/// asset's folder; a missing one is a finding.
/// @throws Error (asset) with the file and the place: an index out of range, a line that is not
/// what its keyword promises.
Asset read_obj(const std::string& path);

/// Reads OBJ from memory; `path` is for messages and for the files that it names.
Asset parse_obj(std::string_view bytes, const std::string& path);

}  // namespace elastogen
