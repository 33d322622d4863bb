// SPDX-License-Identifier: Apache-2.0
#include "io/splat_reader.hpp"

#include "tests/io/cloud_files.hpp"

namespace elastogen {
namespace {

using test::bytes_of;
using test::error_of;
using test::expect_says;

/// One splat with a quaternion of bytes.
std::string splat_of(float x, float scale, std::array<uint8_t, 4> q) {
  return bytes_of(x, 2.f, 3.f, scale, 0.2f, 0.3f, uint8_t(255), uint8_t(0), uint8_t(51),
                  uint8_t(102), q[0], q[1], q[2], q[3]);
}

TEST(SplatReader, UnpacksEveryNumber) {
  const Asset asset = test::checked(parse_splat, splat_of(1, 0.1f, {192, 64, 192, 192}));
  const SplatCloud& s = *asset.splats;
  EXPECT_EQ(asset.format, "splat");
  EXPECT_EQ(s.degree, 0);
  EXPECT_EQ(s.position, (std::vector<Vec3>{{1, 2, 3}}));
  EXPECT_EQ(s.scale.at(0), (std::array<float, 3>{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(s.rotation.at(0), (std::array<float, 4>{0.5f, -0.5f, 0.5f, 0.5f}));
  EXPECT_FLOAT_EQ(s.opacity.at(0), 0.4f);
  const double y00 = 0.5 / std::sqrt(M_PI);  // colour = 1/2 + y00 f
  ASSERT_EQ(s.harmonics.size(), 3u);
  EXPECT_NEAR(s.harmonics[0], 0.5 / y00, 1e-6);
  EXPECT_NEAR(s.harmonics[1], -0.5 / y00, 1e-6);
  EXPECT_NEAR(s.harmonics[2], -0.3 / y00, 1e-6);
}

TEST(SplatReader, DropsAndRepairsWithAFinding) {
  const std::array<uint8_t, 4> one = {255, 128, 128, 128};
  const Asset asset =
      test::checked(parse_splat, splat_of(1, 0.1f, one) + splat_of(INFINITY, 0.1f, one) +
                                     splat_of(2, -0.1f, one) + splat_of(3, NAN, one) +
                                     splat_of(4, 0, {128, 128, 128, 128}));
  EXPECT_EQ(asset.splats->position, (std::vector<Vec3>{{1, 2, 3}, {4, 2, 3}}));
  EXPECT_EQ(asset.splats->rotation.at(1), (std::array<float, 4>{1, 0, 0, 0}));
  EXPECT_GT(asset.splats->scale.at(1)[0], 0);
  EXPECT_EQ(asset.splats->harmonics.size(), 6u);
  EXPECT_EQ(test::finding_of(asset, "bad-splats"), 3);
  EXPECT_EQ(test::finding_of(asset, "bad-rotations"), 1);
  expect_says(asset.findings[0].text, "the first is number 1 (counted from 0)");
}

TEST(SplatReader, RefusesWhatCannotBe) {
  const std::string file = splat_of(NAN, 1, {255, 128, 128, 128});
  expect_says(error_of([] { parse_splat("", "file"); }), "file: has 0 bytes, no multiple");
  expect_says(error_of([&] { parse_splat(file + "x", "file"); }), "has 33 bytes, no multiple");
  expect_says(error_of([&] { test::checked(parse_splat, file); }),
              "none of its 1 splats is finite: nothing to simulate");
}

TEST(SplatReader, NoCutAndNoByteBreaksIt) {
  const std::string file = splat_of(1, 0.1f, {255, 128, 128, 128});
  test::expect_no_cut_is_read(parse_splat, file);
  test::expect_any_byte_is_read_or_refused(parse_splat, file);
}

}  // namespace
}  // namespace elastogen
