// SPDX-License-Identifier: Apache-2.0
// Gaussian splats in the .splat layout (antimatter15) to an Asset.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// 32 bytes a splat: three floats of position, three of scale; then bytes: red, green, blue,
/// opacity and the quaternion w x y z, where the byte 128 is 0.
/// @throws Error (asset) if the size is no multiple of 32 bytes or the file is empty.
Asset read_splat(const std::string& path);

/// Reads splats from memory; `path` is for messages.
Asset parse_splat(std::string_view bytes, const std::string& path);

}  // namespace elastogen
