// SPDX-License-Identifier: Apache-2.0
#include "reader/image_reader.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>
#include <jpeglib.h>
#include <png.h>
#include <webp/encode.h>

#include <cstdio>  // for jpeglib.h
#include <cstdlib>

namespace elastogen {
namespace {

constexpr int kWidth = 48, kHeight = 32;

/// Red on the left, blue on the right, above; black below.
std::vector<uint8_t> flag() {
  std::vector<uint8_t> rgb;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool above = y < kHeight / 2, left = x < kWidth / 2;
      rgb.insert(rgb.end(),
                 {uint8_t(above && left ? 255 : 0), 0, uint8_t(above && !left ? 255 : 0)});
    }
  return rgb;
}

std::string png() {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = kWidth, image.height = kHeight, image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  const std::vector<uint8_t> rgb = flag();
  png_image_write_to_memory(&image, nullptr, &size, 0, rgb.data(), 0, nullptr);
  std::string bytes(size, '\0');
  png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr);
  bytes.resize(size);
  return bytes;
}

std::string jpeg() {
  jpeg_compress_struct info = {};
  jpeg_error_mgr errors = {};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = kWidth, info.image_height = kHeight;
  info.input_components = 3, info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 95, TRUE);
  jpeg_start_compress(&info, TRUE);
  std::vector<uint8_t> rgb = flag();
  for (int y = 0; y < kHeight; ++y) {
    JSAMPROW row = rgb.data() + 3 * kWidth * y;
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  const std::string result(reinterpret_cast<char*>(bytes), size);
  std::free(bytes);
  return result;
}

std::string webp() {
  uint8_t* bytes = nullptr;
  const size_t size = WebPEncodeLosslessRGB(flag().data(), kWidth, kHeight, 3 * kWidth, &bytes);
  const std::string result(reinterpret_cast<char*>(bytes), size);
  WebPFree(bytes);
  return result;
}

TEST(ImageReader, ReadsPngJpegAndWebp) {
  for (const std::string& bytes : {png(), jpeg(), webp()}) {
    const Image image = read_image(bytes, 4096);
    ASSERT_EQ(image.width, kWidth);
    ASSERT_EQ(image.height, kHeight);
    const auto at = [&](int x, int y, int c) {
      return image.rgba[size_t(4 * (kWidth * y + x) + c)];
    };
    const int expected[3][6] = {
        {8, 8, 255, 0, 0, 255}, {40, 8, 0, 0, 255, 255}, {8, 24, 0, 0, 0, 255}};
    for (const auto& [x, y, r, g, b, a] : expected) {
      EXPECT_NEAR(at(x, y, 0), r, 6);  // JPEG of good quality
      EXPECT_NEAR(at(x, y, 1), g, 6);
      EXPECT_NEAR(at(x, y, 2), b, 6);
      EXPECT_EQ(at(x, y, 3), a);
    }
  }
}

TEST(ImageReader, DamagedImagesAreErrorsOrImages) {
  for (const std::string& whole : {png(), jpeg(), webp()}) {
    for (size_t size = 0; size < whole.size(); ++size) try {
        EXPECT_EQ(read_image(whole.substr(0, size), 4096).rgba.size(), 4u * kWidth * kHeight);
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kAsset);
      }
    for (size_t at = 0; at < whole.size(); ++at) {
      std::string bytes = whole;
      bytes[at] = char(~bytes[at]);
      try {
        read_image(bytes, 64);
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kAsset);
      }
    }
  }
}

TEST(ImageReader, HalvesByTheMeanOfWhatIsSeen) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = 2, image.format = PNG_FORMAT_RGBA;
  // one white texel that is seen, three black ones that are not
  const uint8_t rgba[16] = {255, 255, 255, 255};
  std::string bytes(1000, '\0');
  png_alloc_size_t size = bytes.size();
  ASSERT_TRUE(png_image_write_to_memory(&image, bytes.data(), &size, 0, rgba, 0, nullptr));
  bytes.resize(size);
  EXPECT_EQ(read_image(bytes, 1).rgba, (std::vector<uint8_t>{255, 255, 255, 64}));
}

TEST(ImageReader, RefusesOtherFormats) {
  for (const char* bytes : {"", "GIF89a", "\xabKTX 20\xbb\r\n\x1a\n", "BM"})
    EXPECT_THROW(read_image(bytes, 64), Error);
}

}  // namespace
}  // namespace elastogen
