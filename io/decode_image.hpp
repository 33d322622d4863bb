// SPDX-License-Identifier: Apache-2.0
// Images of foreign files, decoded to pixels by the reader process.

#pragma once

#include "io/child_process.hpp"
#include "io/gltf_source.hpp"

#include <string_view>

namespace elastogen {

inline constexpr int kMaxImageEdge = 16384;                   ///< of an image that is decoded
inline constexpr int64_t kMaxImagePixels = int64_t{1} << 27;  ///< of an image that is decoded
inline constexpr std::string_view kImageWord = "image";       ///< asks the reader for an image

/// Pixels row by row from the top: red, green, blue (sRGB), alpha.
struct Image {
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;  ///< (height * width * 4)
};

/// The stream of an image, as the reader process answers it.
std::string encode_image(const Image& image);

/// Reads the image from a stream. @throws Error (asset): the failure that was encoded, or bytes
/// that are no such stream.
Image decode_image_stream(std::string_view bytes);

/// Decodes PNG, JPEG or WebP in the reader process.
/// @param max_edge  the image is halved until no edge is longer.
/// @throws Error (asset): another format, a damaged image, more than kMaxImageEdge or
///         kMaxImagePixels, the limits of the reader, its crash.
Image decode_image(const Bytes& bytes, int max_edge, const ChildOptions& options = {});

}  // namespace elastogen
