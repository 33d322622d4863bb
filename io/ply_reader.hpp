// SPDX-License-Identifier: Apache-2.0
// PLY to an Asset, positions in double precision and in the order of the file.

#pragma once

#include "io/asset.hpp"
#include "io/read_options.hpp"

#include <string_view>

namespace elastogen {

/// Text (an item a line) and binary of both byte orders; one mesh. Known vertex properties: x y z,
/// nx ny nz, s t (u v, texture_u texture_v), red green blue alpha (integers: sRGB of their range;
/// floats: linear); further numbers become Mesh::own. Faces: io/ply_faces.hpp. What is left out is
/// a finding. Without faces it is a point cloud, or Gaussian splats (io/ply_splats.hpp).
/// @throws Error (asset) with the file and the place: a header that is no PLY header, counts beyond
/// the file's size, a line with too few or too many numbers, triangle strips.
Asset read_ply(const std::string& path, const ReadOptions& options);
Asset read_ply(const std::string& path);

/// Reads PLY from memory; `path` is for messages and for the files that it names.
Asset parse_ply(std::string_view bytes, const std::string& path, const ReadOptions& options);
Asset parse_ply(std::string_view bytes, const std::string& path);

}  // namespace elastogen
