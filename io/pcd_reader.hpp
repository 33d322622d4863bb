// SPDX-License-Identifier: Apache-2.0
// PCD point clouds (Point Cloud Library, version 0.7 and before) to an Asset.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// DATA ascii, binary and binary_compressed; fields x y z, rgb or rgba (packed, sRGB), normal_x
/// normal_y normal_z. Other fields and the viewpoint are skipped. Points that are nan, by which
/// organised clouds mark gaps, are left to the check.
/// @throws Error (asset) with file and line: a header line that is not what its keyword promises,
///         no x y z, counts that contradict each other or are beyond the bytes that follow.
Asset read_pcd(const std::string& path);

/// Reads PCD from memory; `path` is for messages.
Asset parse_pcd(std::string_view bytes, const std::string& path);

}  // namespace elastogen
