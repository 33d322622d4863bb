// SPDX-License-Identifier: Apache-2.0
#include "io/decode_image.hpp"

#include "io/flat_stream.hpp"
#include "tests/io/image_files.hpp"
#include "tests/io/test_files.hpp"

namespace elastogen::test {
namespace {

Bytes bytes_of(const std::string& text) {
  return Bytes(text.begin(), text.end());
}

TEST(DecodeImage, GivesEveryPixelOfAPng) {
  std::vector<uint8_t> rgba(4 * 5 * 3);
  for (size_t k = 0; k < rgba.size(); ++k) rgba[k] = uint8_t(k % 4 == 3 ? 255 - k : 37 * k);
  const Image image = decode_image(bytes_of(png_of(5, 3, rgba)), 16);
  EXPECT_EQ(image.width, 5);
  EXPECT_EQ(image.height, 3);
  EXPECT_EQ(image.rgba, rgba);
}

TEST(DecodeImage, HalvesWhatIsTooLong) {
  const std::vector<uint8_t> rgba(4 * 100 * 30, 200);
  const Image image = decode_image(bytes_of(png_of(100, 30, rgba)), 40);
  EXPECT_EQ(image.width, 25);
  EXPECT_EQ(image.height, 7);
  EXPECT_EQ(image.rgba, std::vector<uint8_t>(4 * 25 * 7, 200));
}

TEST(DecodeImage, RefusesWhatIsDamagedOrNoImage) {
  const std::string png = four_colours();
  for (size_t size = 8; size < png.size() - 12; size += 5)
    error_of([&] { decode_image(bytes_of(png.substr(0, size)), 16); });
  std::string flipped = png;
  flipped[45] = char(~flipped[45]);
  error_of([&] { decode_image(bytes_of(flipped), 16); });
  expect_says(error_of([] { decode_image({}, 16); }), "only PNG, JPEG and WebP");
  expect_says(error_of([] { decode_image(bytes_of("\xabKTX 20\xbb\r\n\x1a\n    "), 16); }),
              "image/ktx2");
  expect_says(error_of([&] { decode_image(bytes_of(png), 0); }, ErrorKind::kUsage), "positive");
}

TEST(DecodeImage, RefusesSizesOutOfRange) {
  // the header alone claims them
  std::string png = png_of(1, 1, {0, 0, 0, 0});
  png[18] = '\x7f';
  const auto check = crc32(0, reinterpret_cast<const Bytef*>(png.data() + 12), 17);
  for (size_t k = 0; k < 4; ++k) png[29 + k] = char(check >> (24 - 8 * k));
  expect_says(error_of([&] { decode_image(bytes_of(png), 16); }), "out of range");
}

TEST(DecodeImage, TrustsNoStream) {
  const Image image{2, 1, {1, 2, 3, 4, 5, 6, 7, 8}};
  const std::string stream = encode_image(image);
  EXPECT_EQ(decode_image_stream(stream).rgba, image.rgba);
  for (size_t size = 0; size < stream.size(); ++size)
    error_of([&] { decode_image_stream(stream.substr(0, size)); });
  error_of([&] { decode_image_stream(stream + '\0'); });
  for (const Image& wrong : {Image{2, 2, image.rgba}, Image{-2, -1, image.rgba}, Image{0, 0, {}},
                             Image{1 << 20, 1, image.rgba}})
    error_of([&] { decode_image_stream(encode_image(wrong)); });
  expect_says(error_of([] { decode_image_stream(encode_failure(ReaderFailure::kRefused, "why")); }),
              "why");
}

}  // namespace
}  // namespace elastogen::test
