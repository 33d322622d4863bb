// SPDX-License-Identifier: Apache-2.0
// Reads PNG, JPEG and WebP through their libraries.

#pragma once

#include "io/decode_image.hpp"

namespace elastogen {

/// Decodes an image in the format that its first bytes tell.
/// @param max_edge  the image is halved until no edge is longer.
/// @throws Error (asset): another format, a damaged image, more than kMaxImageEdge or
///         kMaxImagePixels.
Image read_image(const std::string& bytes, int max_edge);

}  // namespace elastogen
