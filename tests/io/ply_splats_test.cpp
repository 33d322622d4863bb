// SPDX-License-Identifier: Apache-2.0
#include "io/ply_splats.hpp"

#include "io/ply_reader.hpp"
#include "io/splat_ply.hpp"
#include "io/splat_reader.hpp"
#include "io/spz_reader.hpp"
#include "tests/io/cloud_files.hpp"

#include <functional>

namespace elastogen {
namespace {

using test::bytes_of;
using test::checked;
using test::error_of;
using test::expect_says;

/// Header of splats whose properties are floats.
std::string header_of(int64_t splats, int rest, const std::string& extra = "") {
  std::string h = concat("ply\nformat binary_little_endian 1.0\nelement vertex ", splats, "\n");
  const auto add = [&](const std::string& name) { h += "property float " + name + "\n"; };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"})
    add(name);
  for (int k = 0; k < rest; ++k) add(concat("f_rest_", k));
  for (const char* name :
       {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    add(name);
  return h + extra + "end_header\n";
}

/// A splat at (x, 2, 3) with f_rest_k = k.
std::string splat_of(float x, int rest, float logit, std::array<float, 4> q) {
  std::string out = bytes_of(x, 2.f, 3.f, 0.f, 0.f, 0.f, 0.1f, 0.2f, 0.3f);
  for (int k = 0; k < rest; ++k) out += bytes_of(float(k));
  return out + bytes_of(logit, 0.f, 1.f, -1.f, q[0], q[1], q[2], q[3]);
}

TEST(PlySplats, TurnsLogitsLogarithmsAndChannels) {
  const int counts[] = {0, 9, 24, 45};
  for (int degree = 0; degree <= 3; ++degree) {
    const int rest = counts[degree];
    const Asset asset =
        checked(parse_ply, header_of(1, rest) + splat_of(1, rest, 2, {2, 0, 0, -2}));
    const SplatCloud& s = *asset.splats;
    EXPECT_TRUE(asset.meshes.empty() && !asset.points);
    EXPECT_EQ(s.position, (std::vector<Vec3>{{1, 2, 3}}));
    EXPECT_FLOAT_EQ(s.opacity.at(0), 0.88079708f);  // 1 / (1 + e^-2)
    EXPECT_FLOAT_EQ(s.scale.at(0)[0], 1);
    EXPECT_FLOAT_EQ(s.scale.at(0)[1], float(M_E));
    EXPECT_FLOAT_EQ(s.rotation.at(0)[0], float(std::sqrt(0.5)));
    EXPECT_FLOAT_EQ(s.rotation.at(0)[3], -float(std::sqrt(0.5)));
    EXPECT_EQ(s.degree, degree);
    ASSERT_EQ(int(s.harmonics.size()), 3 + rest);
    EXPECT_EQ(s.harmonics[2], 0.3f);
    for (int c = 1; c < rest / 3 + 1; ++c)
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_EQ(s.harmonics[size_t(3 * c + channel)], float(channel * rest / 3 + c - 1));
  }
}

TEST(PlySplats, DropsAndRepairsWithAFinding) {
  const std::array<float, 4> one = {1, 0, 0, 0};
  std::string bad_scale = splat_of(3, 9, 0, one);
  bad_scale = test::with(bad_scale, bad_scale.size() - 28, 1000.f);  // e^1000 overflows
  std::string bad_colour = splat_of(6, 9, INFINITY, one);
  bad_colour = test::with(bad_colour, 36, NAN);
  const Asset asset =
      checked(parse_ply, header_of(6, 9) + splat_of(1, 9, 0, {0, 0, 0, 0}) +
                             splat_of(NAN, 9, 0, one) + bad_scale + splat_of(4, 9, NAN, one) +
                             bad_colour + splat_of(7, 9, -INFINITY, {NAN, 0, 0, 0}));
  const SplatCloud& s = *asset.splats;
  EXPECT_EQ(s.position, (std::vector<Vec3>{{1, 2, 3}, {6, 2, 3}, {7, 2, 3}}));
  EXPECT_EQ(s.rotation.at(0), one);
  EXPECT_EQ(s.rotation.at(2), one);
  EXPECT_EQ(s.opacity, (std::vector<float>{0.5f, 1, 0}));  // infinite logits are the ends
  ASSERT_EQ(s.harmonics.size(), 36u);
  EXPECT_EQ(s.harmonics[12 + 3], 0);
  EXPECT_EQ(s.harmonics[12 + 6], 1);  // coefficient 2 of red: f_rest_1
  EXPECT_EQ(test::finding_of(asset, "bad-splats"), 3);
  EXPECT_EQ(test::finding_of(asset, "bad-rotations"), 2);
  EXPECT_EQ(test::finding_of(asset, "bad-harmonics"), 1);
}

/// Splats over a ball of that radius by float columns; `row` gives the numbers after x y z.
std::string ball_file(double radius, int count, std::initializer_list<const char*> names,
                      const std::function<std::string(int)>& row, const char* type = "float") {
  std::string file = concat("ply\nformat binary_little_endian 1.0\nelement vertex ", count, "\n");
  for (const char* name : {"x", "y", "z"}) file += concat("property float ", name, "\n");
  for (const std::string name : names)
    file +=
        concat("property ",
               name.size() > 2 && name.find('_') == name.npos && name != "opacity" ? type : "float",
               ' ', name, "\n");
  file += "end_header\n";
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.) / count, r = std::sqrt(1 - z * z), a = 2.399963 * i;
    file += bytes_of(float(radius * r * std::cos(a)), float(radius * r * std::sin(a)),
                     float(radius * z)) +
            row(i);
  }
  return file;
}

const auto kAll = {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
                   "rot_2",   "rot_3",   "f_dc_0",  "f_dc_1",  "f_dc_2"};

TEST(PlySplats, LinearSizesAreToldFromLogarithms) {
  for (const double radius : {0.01, 0.5, 20., 500.})  // metres to millimetres
    for (const int count : {300, 5000}) {
      const float size = float(radius * std::sqrt(4 * M_PI / count));
      for (const bool linear : {false, true}) {
        const std::string file = ball_file(radius, count, kAll, [&](int i) {
          const float s = size * float(1 + 0.3 * (i % 3)), a = 0.2f + 0.1f * float(i % 8);
          const auto number = [&](float x) { return linear ? x : std::log(x); };
          return bytes_of(linear ? a : std::log(a / (1 - a)), number(s), number(s), number(s / 3),
                          1.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f);
        });
        const Asset asset = checked(parse_ply, file);
        EXPECT_EQ(test::finding_of(asset, "linear-splats"), linear ? count : 0)
            << radius << ' ' << count;
        EXPECT_NEAR(asset.splats->scale[1][0] / size, 1.3, 1e-4) << radius << ' ' << linear;
        EXPECT_NEAR(asset.splats->opacity[1], 0.3, 1e-5);
      }
    }
}

TEST(PlySplats, ScalesAreWhatTheOptionSays) {
  const std::string file = ball_file(1, 100, kAll, [](int) {
    return bytes_of(0.5f, 0.125f, 0.25f, 0.0625f, 1.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f);
  });
  const SplatCloud linear = *parse_ply(file, "f", {SplatScales::kLinear, ""}).splats;
  EXPECT_EQ(linear.scale[0], (std::array<float, 3>{0.125f, 0.25f, 0.0625f}));
  EXPECT_EQ(linear.opacity[0], 0.5f);
  const Asset logs = parse_ply(file, "f", {SplatScales::kLog, ""});
  EXPECT_FLOAT_EQ(logs.splats->scale[0][1], std::exp(0.25f));
  EXPECT_NEAR(logs.splats->opacity[0], 1 / (1 + std::exp(-0.5)), 1e-6);
  EXPECT_TRUE(logs.findings.empty());
  EXPECT_EQ(splat_scales_name(splat_scales_from_name("linear")), "linear");
  expect_says(error_of([] { splat_scales_from_name("lin"); }, ErrorKind::kUsage),
              "known are auto, log and linear");
}

TEST(PlySplats, ColoursStandInForHarmonicsAndOpacityIsOneWithout) {
  const auto names = {"scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
                      "rot_2",   "rot_3",   "red",     "green", "blue"};
  const std::string file = ball_file(
      1, 50, names,
      [](int) {
        return bytes_of(-3.f, -3.f, -3.f, 1.f, 0.f, 0.f, 0.f, uint8_t(255), uint8_t(0),
                        uint8_t(51));
      },
      "uchar");
  const Asset asset = checked(parse_ply, file);
  ASSERT_TRUE(asset.splats);
  const double y00 = 0.5 / std::sqrt(M_PI);
  EXPECT_NEAR(0.5 + y00 * asset.splats->harmonics[0], 1, 1e-6);
  EXPECT_NEAR(0.5 + y00 * asset.splats->harmonics[1], 0, 1e-6);
  EXPECT_NEAR(0.5 + y00 * asset.splats->harmonics[2], 0.2, 1e-6);
  EXPECT_EQ(asset.splats->opacity[7], 1);
  EXPECT_FLOAT_EQ(asset.splats->scale[7][0], std::exp(-3.f));
  EXPECT_EQ(test::finding_of(asset, "splat-colours"), 50);
  EXPECT_EQ(test::finding_of(asset, "splat-opacity"), 50);
  EXPECT_TRUE(asset.splats->own.columns.empty());
}

TEST(PlySplats, RefusesByTheColumnThatIsMissing) {
  const std::string whole = header_of(1, 0) + splat_of(1, 0, 0, {1, 0, 0, 0});
  for (const std::string name : {"scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2",
                                 "rot_3", "f_dc_0", "f_dc_1", "f_dc_2", "x"}) {
    std::string file = whole;
    file.replace(file.find("float " + name + "\n") + 6, name.size(), std::string(name.size(), 'q'));
    expect_says(error_of([&] { checked(parse_ply, file); }), "has no number " + name);
  }
}

TEST(PlySplats, OwnColumnsKeepTheirTypesAndValues) {
  const std::string extra =
      "property int label\nproperty double confidence\nproperty list uchar int ids\n";
  std::string file = header_of(2, 0, extra);
  for (const int k : {0, 1})
    file +=
        splat_of(float(k), 0, 0, {1, 0, 0, 0}) + bytes_of(2000000001 + k, 0.1 + k, uint8_t(1), 5);
  const Asset asset = checked(parse_ply, file);
  const OwnColumns& own = asset.splats->own;
  ASSERT_EQ(own.columns.size(), 2u);
  EXPECT_EQ(own.columns[0].name + own.columns[1].name, "labelconfidence");
  EXPECT_EQ(own.rows, bytes_of(2000000001, 0.1, 2000000002, 1.1));
  EXPECT_EQ(test::finding_of(asset, "carried-columns"), 2);
  EXPECT_EQ(test::finding_of(asset, "lost-columns"), 1);  // a list
  for (const Finding& finding : asset.findings)
    expect_says(finding.text, finding.what == "carried-columns" ? "label, confidence" : "ids");
}

TEST(PlySplats, AMeshWithTheirPropertiesStaysAMesh) {
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  std::string file = header_of(3, 0, faces);
  for (const float x : {0.f, 1.f, 2.f})
    file += test::with(splat_of(x, 0, 0, {1, 0, 0, 0}), 4, x * x);
  const Asset asset = checked(parse_ply, file + bytes_of(uint8_t(3), 0, 1, 2));
  EXPECT_EQ(asset.meshes.size(), 1u);
  EXPECT_FALSE(asset.splats);
}

TEST(PlySplats, RefusesWhatCannotBe) {
  const std::string splat = splat_of(1, 0, 0, {1, 0, 0, 0});
  std::string no_scale = header_of(1, 0);
  no_scale.replace(no_scale.find("scale_2"), 7, "scale_x");
  std::string gap = header_of(1, 9);
  gap.replace(gap.find("f_rest_8"), 8, "f_rest_9");
  const std::pair<std::string, std::string> cases[] = {
      {header_of(1, 10) + splat_of(1, 10, 0, {1, 0, 0, 0}), "have 10 properties f_rest_*"},
      {header_of(1, 72) + splat_of(1, 72, 0, {1, 0, 0, 0}), "have 72 properties f_rest_*"},
      {no_scale + splat, "its element vertex has no number scale_2"},
      {gap + splat_of(1, 9, 0, {1, 0, 0, 0}), "has no number f_rest_8"},
      {header_of(2, 0) + splat, "the header claims 2 times vertex but only 68 bytes follow"},
      {header_of(2147483646, 0) + splat, "the header claims 2147483646 times vertex"},
      {header_of(2147483648, 0) + splat, "has no valid count"},
      {header_of(0, 0), "has no splats: nothing to simulate"},
      {header_of(1, 0) + splat_of(NAN, 0, 0, {1, 0, 0, 0}), "none of its 1 splats is finite"},
  };
  for (const auto& [bytes, message] : cases)
    expect_says(error_of([&, &b = bytes] { checked(parse_ply, b); }), message);
}

TEST(PlySplats, NoCutAndNoByteBreaksIt) {
  const std::string file = header_of(1, 9) + splat_of(1, 9, 0, {1, 0, 0, 0});
  test::expect_no_cut_is_read(parse_ply, file);
  test::expect_any_byte_is_read_or_refused(parse_ply, file);
}

TEST(SplatPly, WhatIsWrittenReadsBack) {
  for (const float a : {0.f, 1e-6f, 0.01f, 0.5f, 0.9f, 0.999999f, 1.f}) {
    EXPECT_TRUE(std::isfinite(logit_opacity(a)));
    EXPECT_NEAR(opacity_of_logit(logit_opacity(a)), a, 1e-6);
  }
  EXPECT_EQ(logit_opacity(0.5f), 0);
  EXPECT_FLOAT_EQ(logit_opacity(0.88079708f), 2);
  for (const float s : {1e-7f, 0.003f, 1.f, 12.f, 4e5f})
    EXPECT_NEAR(scale_of_log(log_scale(s)) / s, 1, 1e-6);
  std::vector<bool> taken(45);
  for (int c = 1; c < harmonic_count(3); ++c)
    for (int channel = 0; channel < 3; ++channel)
      taken.at(size_t(f_rest_index(3, c, channel))) = true;
  EXPECT_EQ(std::count(taken.begin(), taken.end(), true), 45);
  EXPECT_EQ(f_rest_index(3, 2, 1), 16);  // green follows the 15 of red
  EXPECT_EQ(f_rest_index(1, 3, 2), 8);
}

/// A compressed file of splats that all have these words, all chunks with these ranges.
std::string packed_file(int splats, int chunks, std::array<uint32_t, 4> words, bool colours,
                        bool harmonics = false) {
  std::string file = concat("ply\nformat binary_little_endian 1.0\nelement chunk ", chunks, "\n");
  for (const char* end : {"min_", "max_"})
    for (const char* name : {"x", "y", "z", "scale_x", "scale_y", "scale_z", "r", "g", "b"})
      if (colours || std::strlen(name) > 1 || *name >= 'x')
        file += concat("property float ", end, name, "\n");
  file += concat("element vertex ", splats, "\n");
  for (const char* name : {"position", "rotation", "scale", "color"})
    file += concat("property uint packed_", name, "\n");
  if (harmonics) file += concat("element sh ", splats, "\nproperty uchar f_rest_0\n");
  file += "end_header\n";
  for (int k = 0; k < chunks; ++k) {
    const float x = float(100 * k);
    file += bytes_of(x, 0.f, -1.f, -2.f, -3.f, -4.f);
    if (colours) file += bytes_of(-1.f, 0.f, 0.f);
    file += bytes_of(x + 1, 10.f, 1.f, 0.f, 1.f, 2.f);
    if (colours) file += bytes_of(2.f, 1.f, 1.f);
  }
  for (int k = 0; k < splats; ++k) file += bytes_of(words[0], words[1], words[2], words[3]);
  if (harmonics) file += std::string(size_t(splats), 'h');
  return file;
}

/// Lowest x, middle y (of 1023), highest z.
constexpr uint32_t kPosition = 0u << 21 | 512u << 11 | 2047u;
/// Highest, lowest, lowest: e^0, e^-3, e^-4.
constexpr uint32_t kScale = 2047u << 21;
constexpr uint32_t kColour = 0xff003366;

TEST(PackedSplats, UnpacksEveryNumber) {
  // w x y z without the largest: 1023, 0 and 512 of 1023, from -1/sqrt(2) to 1/sqrt(2)
  const double h = std::sqrt(0.5), c = (512 / 1023. - 0.5) * std::sqrt(2.);
  const double expected[4][4] = {{0, h, -h, c}, {h, 0, -h, c}, {h, -h, 0, c}, {h, -h, c, 0}};
  for (uint32_t largest = 0; largest < 4; ++largest) {
    const uint32_t rotation = largest << 30 | 1023u << 20 | 0u << 10 | 512u;
    const SplatCloud s =
        *checked(parse_ply, packed_file(257, 2, {kPosition, rotation, kScale, kColour}, true))
             .splats;
    ASSERT_EQ(s.position.size(), 257u);
    EXPECT_EQ(s.position[255], (Vec3{0, 512 / 1023. * 10, 1}));
    EXPECT_EQ(s.position[256], (Vec3{100, 512 / 1023. * 10, 1}));  // of the second chunk
    EXPECT_FLOAT_EQ(s.scale[0][0], 1);
    EXPECT_FLOAT_EQ(s.scale[0][1], float(std::exp(-3)));
    EXPECT_FLOAT_EQ(s.scale[0][2], float(std::exp(-4)));
    for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(s.rotation[0][k], expected[largest][k], 1e-6);
    const double y00 = 0.5 / std::sqrt(M_PI);
    EXPECT_NEAR(s.harmonics[0], (2 - 0.5) / y00, 1e-5);
    EXPECT_NEAR(s.harmonics[1], -0.5 / y00, 1e-5);
    EXPECT_NEAR(s.harmonics[2], (0.2 - 0.5) / y00, 1e-5);
    EXPECT_FLOAT_EQ(s.opacity[0], 0.4f);
  }
}

TEST(PackedSplats, OlderFilesHaveNoRangesOfColour) {
  const Asset asset = checked(parse_ply, packed_file(1, 1, {kPosition, 0, kScale, kColour}, false));
  EXPECT_NEAR(asset.splats->harmonics.at(0), std::sqrt(M_PI), 1e-6);  // white: 1/2 = y00 f
  EXPECT_TRUE(asset.findings.empty());
}

TEST(PackedSplats, LeavesFurtherHarmonicsOutWithAFinding) {
  const Asset asset =
      checked(parse_ply, packed_file(2, 1, {kPosition, 0, kScale, kColour}, true, true));
  EXPECT_EQ(asset.splats->degree, 0);
  EXPECT_EQ(test::finding_of(asset, "harmonics"), 2);
}

TEST(PackedSplats, RefusesWhatCannotBe) {
  const std::array<uint32_t, 4> words = {kPosition, 0, kScale, kColour};
  // files in which a property has another name
  std::string no_range = packed_file(1, 1, words, true);
  no_range.replace(no_range.find("max_y"), 5, "may_y");
  std::string no_colour = packed_file(1, 1, words, true);
  no_colour.replace(no_colour.find("packed_color"), 12, "packed_other");
  // headers of elements, for files that have them in either order
  const std::string vertex =
      "element vertex 1\nproperty uint packed_position\nproperty uint packed_rotation\n"
      "property uint packed_scale\nproperty uint packed_color\n";
  std::string chunk = "element chunk 1\n";
  for (const char* end : {"min_", "max_"})
    for (const char* name : {"x", "y", "z", "scale_x", "scale_y", "scale_z"})
      chunk += concat("property float ", end, name, "\n");
  const std::string head = "ply\nformat ascii 1.0\n", ranges = "0 0 0 0 0 0 1 1 1 1 1 1\n";
  const std::pair<std::string, std::string> cases[] = {
      {packed_file(257, 1, words, true), "257 packed splats need a chunk before them for each 256"},
      {packed_file(1, 0, words, true), "there are 0"},
      {head + vertex + chunk + "end_header\n0 0 0 0\n" + ranges,
       "1 packed splats need a chunk before them"},
      {no_range, "its element chunk has no number max_y"},
      {no_colour, "its element vertex has no number packed_color"},
      {head + chunk + vertex + "end_header\n" + ranges + "-1 0 0 0\n",
       "splat 0 has a packed value of -1, not of 32 bits"},
      {packed_file(0, 0, words, true), "has no splats: nothing to simulate"},
  };
  for (const auto& [bytes, message] : cases)
    expect_says(error_of([&, &b = bytes] { checked(parse_ply, b); }), message);
}

TEST(PackedSplats, NoCutAndNoByteBreaksIt) {
  const std::string file = packed_file(1, 1, {kPosition, 0, kScale, kColour}, true);
  test::expect_no_cut_is_read(parse_ply, file);
  test::expect_any_byte_is_read_or_refused(parse_ply, file);
}

/// Largest differences of two clouds; of rotations 1 - |cos| of half the angle between them.
struct Difference {
  double position = 0, log_scale = 0, opacity = 0, colour = 0, rotation = 0;
};

Difference difference_of(const SplatCloud& a, const SplatCloud& b) {
  Difference d;
  for (size_t i = 0; i < a.position.size(); ++i) {
    double cosine = 0;
    for (size_t k = 0; k < 4; ++k) cosine += double(a.rotation[i][k]) * b.rotation[i][k];
    d.rotation = std::max(d.rotation, 1 - std::abs(cosine));
    for (size_t k = 0; k < 3; ++k) {
      d.position = std::max(d.position, std::abs(a.position[i][k] - b.position[i][k]));
      d.log_scale =
          std::max(d.log_scale, std::abs(std::log(double(a.scale[i][k]) / b.scale[i][k])));
      const auto colour = [&](const SplatCloud& s) {
        return std::clamp(0.5 + kHarmonic0 * s.harmonics[3 * i + k], 0., 1.);
      };
      d.colour = std::max(d.colour, std::abs(colour(a) - colour(b)));
    }
    d.opacity = std::max(d.opacity, std::abs(double(a.opacity[i]) - b.opacity[i]));
  }
  return d;
}

SplatCloud read(const std::string& path, Asset (*reader)(const std::string&)) {
  Asset asset = reader(path);
  check_asset(asset);
  EXPECT_EQ(test::finding_of(asset, "bad-splats"), 0) << path;
  return *asset.splats;
}

TEST(PlySplats, RealFilesOfOneSceneAgreeToTheirQuantisation) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  // one scene in three formats
  const SplatCloud packed = read(folder + "splats/guitar.compressed.ply", read_ply);
  const SplatCloud plain = read(folder + "splats/guitar_3dgs.ply", read_ply);
  const SplatCloud bytes = read(folder + "splats/guitar.splat", read_splat);
  for (const SplatCloud* s : {&packed, &plain, &bytes}) EXPECT_EQ(s->position.size(), 90854u);
  const Difference a = difference_of(packed, plain);
  EXPECT_LT(a.position, 5e-7);    // floats up to 4.4
  EXPECT_LT(a.log_scale, 2e-6);   // floats up to 16
  EXPECT_LT(a.opacity, 1.01e-4);  // the file keeps them 1e-4 away from 0 and 1
  EXPECT_LT(a.colour, 1e-6);
  EXPECT_LT(a.rotation, 1e-6);
  const Difference b = difference_of(packed, bytes);
  EXPECT_LT(b.position, 5e-7);
  EXPECT_LT(b.log_scale, 2e-6);
  EXPECT_LT(b.opacity, 0.51 / 255);
  EXPECT_LT(b.colour, 0.51 / 255);
  EXPECT_LT(b.rotation, 4. / (2 * 128 * 128) * 1.1);  // each component rounded down, 1/128

  // another scene in two formats
  const SplatCloud spot = read(folder + "splats/spot_3dgs.ply", read_ply);
  const SplatCloud spz = read(folder + "splats/spot.spz", read_spz);
  for (const SplatCloud* s : {&spot, &spz}) EXPECT_EQ(s->position.size(), 20000u);
  const Difference c = difference_of(spot, spz);
  EXPECT_LT(c.position, 1.01 / 8192);  // half of 2^-12
  EXPECT_LT(c.log_scale, 1.01 / 32);
  EXPECT_LT(c.opacity, 0.51 / 255);
  EXPECT_LT(c.colour, 0.51 / 255 / 0.15 * kHarmonic0);
  EXPECT_LT(c.rotation, 0.01);  // w follows from xyz of 8 bits

  const SplatCloud train = read(folder + "splats/train_1000.ply", read_ply);
  EXPECT_EQ(train.position.size(), 1000u);
  EXPECT_EQ(train.degree, 3);
  EXPECT_EQ(train.harmonics.size(), 48000u);
}

}  // namespace
}  // namespace elastogen
