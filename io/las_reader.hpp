// SPDX-License-Identifier: Apache-2.0
// LAS point clouds (ASPRS LAS 1.0 to 1.4, not compressed) to an Asset.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// Point formats 0 to 10: positions scale * integer + offset in double precision, RGB where the
/// format has it (8 bits if no value needs 16), z up as the standard has it.
/// @throws Error (asset) with the file: no LAS header, another version or point format, compressed
///         points (LAZ), a record shorter than its format, fewer bytes than the counts claim.
Asset read_las(const std::string& path);

/// Reads LAS from memory; `path` is for messages.
Asset parse_las(std::string_view bytes, const std::string& path);

}  // namespace elastogen
