// SPDX-License-Identifier: Apache-2.0
// Small PNG files, made by hand.

#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <vector>

namespace elastogen::test {

/// 8-bit RGBA rows from the top as a PNG.
inline std::string png_of(int width, int height, const std::vector<uint8_t>& rgba) {
  // chunks with length and checksum
  const auto word = [](uint32_t v) {
    return std::string{char(v >> 24), char(v >> 16), char(v >> 8), char(v)};
  };
  const auto chunk = [&](const std::string& type, const std::string& data) {
    const std::string body = type + data;
    const auto check =
        crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
    return word(uint32_t(data.size())) + body + word(uint32_t(check));
  };
  // rows without a filter, deflated
  std::string raw;
  for (int y = 0; y < height; ++y) {
    raw += '\0';
    raw.append(reinterpret_cast<const char*>(rgba.data()) + size_t(y) * 4 * size_t(width),
               4 * size_t(width));
  }
  uLongf size = compressBound(uLong(raw.size()));
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size,
           reinterpret_cast<const Bytef*>(raw.data()), uLong(raw.size()));
  packed.resize(size);
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR",
               word(uint32_t(width)) + word(uint32_t(height)) + std::string({8, 6, 0, 0, 0})) +
         chunk("IDAT", packed) + chunk("IEND", "");
}

/// Red above left, green above right, blue below left, white below right.
inline std::string four_colours() {
  return png_of(2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255});
}

}  // namespace elastogen::test
