// SPDX-License-Identifier: Apache-2.0
// Writes PNG: 8-bit RGB in one deflate stream, enough for the pictures of this project.

#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace elastogen {

/// The bytes of a PNG. @param rgb  row by row from the top, (height * width * 3).
/// @throws Error unless width, height > 0 fit the pixels.
std::string encode_png(int width, int height, std::span<const uint8_t> rgb);

}  // namespace elastogen
