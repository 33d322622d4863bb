// SPDX-License-Identifier: Apache-2.0
#include "cli/contact_sheet.hpp"

#include "cli/png.hpp"
#include "core/error.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>
#include <vector>

namespace elastogen {
namespace {

using Rgb = std::array<int, 3>;

struct Picture {
  int width = 0, height = 0;
  std::string rows;  // each with its filter byte

  Rgb at(int x, int y) const {
    const auto* p = reinterpret_cast<const uint8_t*>(rows.data()) + y * (3 * width + 1) + 1 + 3 * x;
    return {p[0], p[1], p[2]};
  }
};

uint32_t word(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t k = 0; k < 4; ++k) value = value << 8 | uint8_t(bytes[at + k]);
  return value;
}

/// Decodes chunk by chunk, each checksum compared.
Picture decode(const std::string& png) {
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  Picture picture;
  for (size_t at = 8; at < png.size();) {
    const size_t size = word(png, at);
    const std::string type = png.substr(at + 4, 4), data = png.substr(at + 8, size);
    const auto* body = reinterpret_cast<const Bytef*>(png.data()) + at + 4;
    EXPECT_EQ(word(png, at + 8 + size), crc32(0, body, uInt(size + 4))) << type;
    if (type == "IHDR") picture.width = int(word(data, 0)), picture.height = int(word(data, 4));
    if (type == "IDAT") {
      uLongf raw = uLongf(picture.height) * uLongf(3 * picture.width + 1);
      picture.rows.resize(raw);
      EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(picture.rows.data()), &raw,
                           reinterpret_cast<const Bytef*>(data.data()), uLong(size)),
                Z_OK);
      EXPECT_EQ(raw, picture.rows.size());
    }
    at += size + 12;
  }
  return picture;
}

TEST(Png, GivesBackEveryPixel) {
  std::vector<uint8_t> rgb(3 * 7 * 5);
  for (size_t k = 0; k < rgb.size(); ++k) rgb[k] = uint8_t(37 * k);
  const Picture picture = decode(encode_png(7, 5, rgb));
  ASSERT_EQ(picture.width, 7);
  ASSERT_EQ(picture.height, 5);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x)
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(picture.at(x, y)[size_t(k)], rgb[size_t(3 * (7 * y + x) + k)]);
}

TEST(Png, RejectsPixelsThatDoNotFit) {
  EXPECT_THROW(encode_png(2, 2, std::vector<uint8_t>(11)), Error);
  EXPECT_THROW(encode_png(0, 2, {}), Error);
}

/// Two squares of edge 1 in planes z = 0 (red) and z = -1 (green), the green one moved by `shift`.
struct Squares {
  Array<double> frame(double shift = 0) const {
    Array<double> x(8, 3);
    for (int n = 0; n < 8; ++n) {
      x(n, 0) = (n & 1) + (n < 4 ? 0 : shift);
      x(n, 1) = n >> 1 & 1;
      x(n, 2) = n < 4 ? 0 : -1;
    }
    return x;
  }
  Squares() {
    const int32_t corner[12] = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6};
    std::copy(corner, corner + 12, triangles.data());
    for (int n = 0; n < 8; ++n) colours(n, n < 4 ? 0 : 1) = 1;
  }
  Array<int32_t> triangles{4, 3};
  Array<float> colours{8, 3};
};

Picture drawn(const std::vector<Array<double>>& frames, const Squares& squares,
              const ContactSheetOptions& options = {.tile = 64}) {
  const std::string path = std::filesystem::temp_directory_path() /
                           ("elastogen_sheet_" + std::to_string(getpid()) + ".png");
  write_contact_sheet(path, frames, squares.triangles, squares.colours, options);
  std::ostringstream content;
  content << std::ifstream(path).rdbuf();
  std::filesystem::remove(path);
  return decode(content.str());
}

bool is_red(const Rgb& c) {
  return c[0] > 60 && c[1] < 20;
}
bool is_green(const Rgb& c) {
  return c[1] > 60 && c[0] < 20;
}

/// Pixels of a tile that satisfy a condition, from the column `left` on.
template <class Condition>
int count(const Picture& picture, int left, int tile, const Condition& condition) {
  int pixels = 0;
  for (int y = 0; y < tile; ++y)
    for (int x = left; x < left + tile; ++x) pixels += condition(picture.at(x, y));
  return pixels;
}

TEST(ContactSheet, HasARowOfTilesForEveryFourFrames) {
  const Squares squares;
  const std::vector<Array<double>> frames(6, squares.frame());
  const Picture picture = drawn(frames, squares, {.tile = 32});
  EXPECT_EQ(picture.width, 4 * 32);
  EXPECT_EQ(picture.height, 2 * 32);
}

TEST(ContactSheet, ShowsTheNearerSurface) {
  const Squares squares;
  const Picture near_red = drawn({squares.frame()}, squares);
  Array<double> turned = squares.frame();
  for (int n = 0; n < 8; ++n) turned(n, 2) = -1 - turned(n, 2);
  const Picture near_green = drawn({turned}, squares);
  EXPECT_GT(count(near_red, 0, 64, is_red), 1.2 * count(near_red, 0, 64, is_green));
  EXPECT_GT(count(near_green, 0, 64, is_green), 1.2 * count(near_green, 0, 64, is_red));
}

TEST(ContactSheet, DoesNotDependOnTheWinding) {
  Squares squares;
  const Picture before = drawn({squares.frame()}, squares);
  for (int t = 0; t < 4; ++t) std::swap(squares.triangles(t, 0), squares.triangles(t, 1));
  EXPECT_EQ(drawn({squares.frame()}, squares).rows, before.rows);
}

TEST(ContactSheet, ScalesAsTheProjectionSays) {
  // far behind each other no square hides the other: red and green cover the same area
  const Squares squares;
  const Picture picture = drawn({squares.frame(8)}, squares, {.tile = 200});
  const int red = count(picture, 0, 200, is_red), green = count(picture, 0, 200, is_green);
  EXPECT_GT(red, 50);
  EXPECT_NEAR(double(green) / red, 1, 0.15);
}

TEST(ContactSheet, KeepsOneCameraForAllFrames) {
  const Squares squares;
  const Picture picture = drawn({squares.frame(), squares.frame(3)}, squares);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      EXPECT_EQ(is_red(picture.at(x, y)), is_red(picture.at(64 + x, y))) << x << ' ' << y;
}

TEST(ContactSheet, DrawsGroundAndShadowBelowTheBody) {
  const Squares squares;
  const Picture open = drawn({squares.frame()}, squares);
  const Picture grounded = drawn({squares.frame()}, squares, {.tile = 64, .floor = -0.5});
  const auto same_as = [](const Rgb& wanted) {
    return [wanted](const Rgb& c) { return c == wanted; };
  };
  const Rgb sky = open.at(0, 0), ground = grounded.at(0, 0);
  EXPECT_NE(sky, ground);
  EXPECT_EQ(count(grounded, 0, 64, same_as(sky)), 0);
  // two upright squares throw two lines of shadow: a plate lying flat throws its own area
  Array<double> flat = squares.frame();
  for (int n = 0; n < 8; ++n) flat(n, 1) = 0, flat(n, 2) = n >> 1 & 1;
  const Picture plate = drawn({flat}, squares, {.tile = 64, .floor = -2});
  const auto is_shadow = [&](const Rgb& c) {
    return c[0] + 30 < ground[0] && std::abs(c[0] - c[1]) < 10 && std::abs(c[1] - c[2]) < 10;
  };
  EXPECT_NEAR(count(plate, 0, 64, is_shadow),
              count(plate, 0, 64, is_red) + count(plate, 0, 64, is_green), 40);
}

TEST(ContactSheet, DrawsNothingOfNoTriangles) {
  Squares squares;
  squares.triangles = Array<int32_t>(0, 3);
  const Picture picture = drawn({squares.frame()}, squares);
  EXPECT_EQ(count(picture, 0, 63, [&](const Rgb& c) { return c != picture.at(0, 0); }), 0);
}

TEST(ContactSheet, RejectsWhatItsDocumentationForbids) {
  Squares squares;
  EXPECT_THROW(drawn({}, squares), Error);
  EXPECT_THROW(drawn({squares.frame(), Array<double>(7, 3)}, squares), Error);
  EXPECT_THROW(drawn({squares.frame()}, squares, {.tile = 0}), Error);
  squares.triangles(0, 0) = 8;
  EXPECT_THROW(drawn({squares.frame()}, squares), Error);
  squares.triangles(0, 0) = 0;
  squares.colours = Array<float>(8, 4);
  EXPECT_THROW(drawn({squares.frame()}, squares), Error);
}

}  // namespace
}  // namespace elastogen
