// SPDX-License-Identifier: Apache-2.0
// The bytes by which the reader process answers with an asset (io/flat_stream.hpp).

#pragma once

#include "io/asset.hpp"
#include "io/flat_stream.hpp"

#include <string>
#include <string_view>

namespace elastogen {

/// The stream of an asset: meshes, points, nodes, materials (textures as the file names them),
/// findings, up and unit.
std::string encode_asset(const Asset& asset);

/// The asset of a stream, its path set to `path`; textures are resolved beside it, those that are
/// not beneath its folder are dropped with a finding. Indices are left to check_asset.
/// @throws Error (asset): the failure that was encoded, in a sentence that begins with the path; a
///         stream that is too short, too long or no stream.
Asset decode_asset(std::string_view bytes, const std::string& path);

}  // namespace elastogen
