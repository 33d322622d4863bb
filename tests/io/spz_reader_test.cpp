// SPDX-License-Identifier: Apache-2.0
#include "io/spz_reader.hpp"

#include "tests/io/cloud_files.hpp"

#include <zlib.h>
#include <zstd.h>

namespace elastogen {
namespace {

using test::bytes_of;
using test::error_of;
using test::expect_says;

std::string gzip(const std::string& bytes) {
  std::string out(bytes.size() + 1000, '\0');
  z_stream stream = {};
  deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = uInt(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(out.size() - stream.avail_out);
  deflateEnd(&stream);
  return out;
}

std::string spz_start(uint32_t version, uint32_t splats, int degree = 0, int fraction = 12,
                      int flags = 0) {
  return bytes_of(0x5053474eu, version, splats, uint8_t(degree), uint8_t(fraction), uint8_t(flags),
                  uint8_t(0));
}

/// Bytes of values of 8 bits.
std::string raw(std::initializer_list<int> values) {
  std::string out;
  for (const int v : values) out += char(v);
  return out;
}

/// Everything of one splat up to its rotation: position 1, -1, 2.5 with 12 bits behind the point.
const std::string kSplat = raw({0x00, 0x10, 0x00, 0x00, 0xf0, 0xff, 0x00, 0x28, 0x00}) + raw({51}) +
                           raw({255, 0, 153}) + raw({160, 176, 144});
const std::string kRotation2 = raw({204, 128, 51});

std::string one_splat() {
  return spz_start(2, 1) + kSplat + kRotation2;
}

void expect_same_splat(const SplatCloud& s) {
  EXPECT_EQ(s.position, (std::vector<Vec3>{{1, -1, 2.5}}));
  EXPECT_FLOAT_EQ(s.opacity.at(0), 0.2f);
  EXPECT_NEAR(s.harmonics.at(0), 0.5 / 0.15, 1e-6);
  EXPECT_NEAR(s.harmonics.at(1), -0.5 / 0.15, 1e-6);
  EXPECT_NEAR(s.harmonics.at(2), 0.1 / 0.15, 1e-6);
  EXPECT_FLOAT_EQ(s.scale.at(0)[0], 1);
  EXPECT_FLOAT_EQ(s.scale.at(0)[1], float(M_E));
  EXPECT_FLOAT_EQ(s.scale.at(0)[2], float(1 / M_E));
}

TEST(SpzReader, UnpacksVersion2) {
  const Asset asset = test::checked(parse_spz, gzip(one_splat()));
  EXPECT_EQ(asset.format, "spz");
  expect_same_splat(*asset.splats);
  const double x = 0.6, y = 0.5 / 127.5, z = -0.6, w = std::sqrt(1 - x * x - y * y - z * z);
  const auto& q = asset.splats->rotation.at(0);
  EXPECT_NEAR(q[0], w, 1e-6);
  EXPECT_NEAR(q[1], x, 1e-6);
  EXPECT_NEAR(q[2], y, 1e-6);
  EXPECT_NEAR(q[3], z, 1e-6);
}

TEST(SpzReader, UnpacksVersion3WithEachLargestComponent) {
  // the others are 100, -200 and 300 of 511 parts of 1/sqrt(2), in the order x y z w
  const double part = std::sqrt(0.5) / 511;
  const double a = 100 * part, b = -200 * part, c = 300 * part;
  const double m = std::sqrt(1 - a * a - b * b - c * c);
  const double expected[4][4] = {{c, m, a, b}, {c, a, m, b}, {c, a, b, m}, {m, a, b, c}};
  for (uint32_t largest = 0; largest < 4; ++largest) {
    const uint32_t word = largest << 30 | 100u << 20 | (512u | 200u) << 10 | 300u;
    const Asset asset = test::checked(parse_spz, gzip(spz_start(3, 1) + kSplat + bytes_of(word)));
    expect_same_splat(*asset.splats);
    for (size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(asset.splats->rotation[0][k], expected[largest][k], 1e-6) << largest << ' ' << k;
  }
}

std::string zstd(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
  return out;
}

/// A file of version 4: one stream an attribute, behind an extension of so many bytes.
std::string version4(uint32_t splats, int degree, const std::vector<std::string>& attributes,
                     uint32_t extension = 0) {
  std::string table, streams;
  for (const std::string& attribute : attributes) {
    const std::string packed = zstd(attribute);
    table += bytes_of(uint64_t(packed.size()), uint64_t(attribute.size()));
    streams += packed;
  }
  return bytes_of(0x5053474eu, 4u, splats, uint8_t(degree), uint8_t(12),
                  uint8_t(extension > 0 ? 2 : 0), uint8_t(attributes.size()), 32 + extension) +
         std::string(12 + extension, '\0') + table + streams;
}

/// The attributes of kSplat with a rotation of version 3 and harmonics.
std::vector<std::string> attributes_of(uint32_t rotation, const std::string& harmonics = "") {
  std::vector<std::string> all = {kSplat.substr(0, 9), kSplat.substr(9, 1), kSplat.substr(10, 3),
                                  kSplat.substr(13, 3), bytes_of(rotation)};
  if (!harmonics.empty()) all.push_back(harmonics);
  return all;
}

TEST(SpzReader, Version4HoldsWhatVersion3Does) {
  const uint32_t word = 3u << 30 | 100u << 20 | (512u | 200u) << 10 | 300u;
  std::string rest;
  for (int k = 0; k < 9; ++k) rest += char(100 + k);
  const SplatCloud three =
      *test::checked(parse_spz, gzip(spz_start(3, 1, 1) + kSplat + bytes_of(word) + rest)).splats;
  for (const uint32_t extension : {0u, 12u}) {
    const std::string file = version4(1, 1, attributes_of(word, rest), extension);
    const SplatCloud four = *test::checked(parse_spz, file).splats;
    expect_same_splat(four);
    EXPECT_EQ(four.rotation, three.rotation);
    EXPECT_EQ(four.harmonics, three.harmonics);
    EXPECT_EQ(four.degree, 1);
  }
  const std::string plain = version4(1, 0, attributes_of(word));  // no stream of harmonics
  expect_same_splat(*test::checked(parse_spz, plain).splats);
  test::expect_no_cut_is_read(parse_spz, plain);
  test::expect_any_byte_is_read_or_refused(parse_spz, plain);
}

TEST(SpzReader, RefusesAVersion4ThatCannotBe) {
  const uint32_t word = 3u << 30;
  const std::string good = version4(1, 0, attributes_of(word));
  std::vector<std::string> few = attributes_of(word), longer = few;
  few.pop_back();
  longer[1] += "x";
  const std::pair<std::string, std::string> cases[] = {
      {good.substr(0, 20), "has no SPZ header of 32 bytes"},
      {test::with(good, 4, 5u), "SPZ version 5 is not read"},
      {version4(1, 0, few), "its splats need 5 streams, it has 4"},
      {version4(1, 0, longer), "unpacks to 2"},
      {good + "x", "1 bytes follow its streams"},
      {test::with(good, 16, 31u), "its table stands at byte 31"},
      {test::with(good, 16, 4000u), "its table stands at byte 4000"},
      {test::with(good, 8, 0x80000000u), "claims 2147483648 splats of 20 bytes, too many"},
      {test::with(good, 32 + 5 * 16, 0u), "a stream of its splats is damaged"},
      {version4(1, 4, attributes_of(word)), "harmonics of degree 4 are not read"},
  };
  for (const auto& [bytes, message] : cases)
    expect_says(error_of([&, &b = bytes] { test::checked(parse_spz, b); }), message);
}

TEST(SpzReader, HarmonicsAreByCoefficientThenChannel) {
  std::string rest;
  for (int k = 0; k < 45; ++k) rest += char(128 + k);
  const SplatCloud s =
      *test::checked(parse_spz, gzip(spz_start(2, 1, 3) + kSplat + kRotation2 + rest)).splats;
  EXPECT_EQ(s.degree, 3);
  ASSERT_EQ(s.harmonics.size(), 48u);
  for (size_t k = 0; k < 45; ++k) EXPECT_EQ(s.harmonics[3 + k], float(k) / 128);
}

TEST(SpzReader, SkipsExtensions) {
  EXPECT_NO_THROW(
      parse_spz(gzip(spz_start(2, 1, 0, 12, 2) + kSplat + kRotation2 + "more"), "file"));
}

TEST(SpzReader, RefusesWhatCannotBe) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "gzip stream is damaged or cut off"},
      {"PK..............", "gzip stream is damaged or cut off"},
      {"NGSP\x04", "has no SPZ header of 32 bytes"},
      {gzip(""), "has no SPZ header of 16 bytes"},
      {gzip("ply\nformat ascii 1.0\n"), "what it packs is no SPZ; unpack it with gunzip"},
      {gzip(spz_start(1, 1) + kSplat), "SPZ version 1 is not read"},
      {gzip(spz_start(4, 1) + kSplat), "SPZ version 4 is not read"},
      {gzip(spz_start(2, 1, 4)), "harmonics of degree 4 are not read"},
      {gzip(spz_start(2, 1, 0, 24)), "cannot have 24 behind the point"},
      {gzip(spz_start(2, 2) + kSplat + kRotation2), "its 2 splats need 38 bytes, it unpacks to 19"},
      {gzip(one_splat() + "x"), "unpacks to more bytes than its 1 splats"},
      {gzip(spz_start(2, 0x80000000)), "claims 2147483648 splats of 19 bytes, too many"},
      {gzip(spz_start(2, 0xffffffff, 3)), "claims 4294967295 splats of 64 bytes, too many"},
      {gzip(spz_start(2, 100000) + std::string(1900000, '\0')), "too many for a file of"},
      {gzip(spz_start(2, 0)), "has no splats: nothing to simulate"},
  };
  for (const auto& [bytes, message] : cases)
    expect_says(error_of([&, &b = bytes] { test::checked(parse_spz, b); }), message);
  std::string damaged = gzip(one_splat());
  damaged[damaged.size() - 8] ^= 1;  // the sum
  expect_says(error_of([&] { parse_spz(damaged, "file"); }), "gzip stream is damaged");
}

TEST(SpzReader, NoCutAndNoByteBreaksIt) {
  test::expect_no_cut_is_read(parse_spz, gzip(one_splat()));
  test::expect_any_byte_is_read_or_refused(parse_spz, gzip(one_splat()));
}

}  // namespace
}  // namespace elastogen
