// SPDX-License-Identifier: Apache-2.0
#include "cli/png.hpp"

#include "core/error.hpp"

#include <zlib.h>

namespace elastogen {

namespace {

std::string big_endian(uint32_t value) {
  return {char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
}

std::string chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const uLong check = crc32(0, reinterpret_cast<const Bytef*>(body.data()), uInt(body.size()));
  return big_endian(uint32_t(data.size())) + body + big_endian(uint32_t(check));
}

std::string deflated(const std::string& raw) {
  uLongf size = compressBound(uLong(raw.size()));
  std::string packed(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                               reinterpret_cast<const Bytef*>(raw.data()), uLong(raw.size()), 6);
  if (status != Z_OK) throw Error("PNG: out of memory", ErrorKind::kResources);
  packed.resize(size);
  return packed;
}

}  // namespace

std::string encode_png(int width, int height, std::span<const uint8_t> rgb) {
  ELASTOGEN_CHECK(width > 0 && height > 0 && rgb.size() == 3 * size_t(width) * size_t(height),
                  "a picture of ", width, " x ", height, " needs 3 bytes a pixel, got ",
                  rgb.size());
  // each row follows a filter byte; 0 means no filter
  std::string raw;
  const size_t row = 3 * size_t(width);
  for (size_t y = 0; y < size_t(height); ++y) {
    raw += '\0';
    raw.append(reinterpret_cast<const char*>(rgb.data()) + y * row, row);
  }
  // 8 bits, RGB, deflate, standard filter set, not interlaced
  const std::string header =
      big_endian(uint32_t(width)) + big_endian(uint32_t(height)) + std::string({8, 2, 0, 0, 0});
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("IDAT", deflated(raw)) +
         chunk("IEND", "");
}

}  // namespace elastogen
