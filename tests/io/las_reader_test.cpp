// SPDX-License-Identifier: Apache-2.0
#include "io/las_reader.hpp"

#include "tests/io/cloud_files.hpp"

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;
using test::with;

constexpr size_t kFormat = 104, kRecordBytes = 105, kPoints = 107, kPoints14 = 247;

/// A header of version 1.minor without points; the points begin behind it.
std::string header_of(int minor, int format, int record_bytes, uint32_t points) {
  const size_t size = minor == 4 ? 375 : 227;
  std::string h(size, '\0');
  h.replace(0, 4, "LASF");
  h = with(h, 24, uint8_t(1), uint8_t(minor));
  h = with(h, 94, uint16_t(size), uint32_t(size));
  h = with(h, kFormat, uint8_t(format), uint16_t(record_bytes), points);
  h = with(h, 131, 0.01, 0.02, 0.5, 8e5, -10., 2.);
  return h;
}

std::string record_of(int record_bytes, int32_t x, int32_t y, int32_t z) {
  return with(std::string(size_t(record_bytes), '\0'), 0, x, y, z);
}

/// Two points of format 3 (34 bytes, colours at byte 28).
std::string two_points(uint16_t red = 65535) {
  return header_of(2, 3, 34, 2) + with(record_of(34, 123, -50, 8), 28, red, uint16_t(0), red) +
         record_of(34, 124, 50, -8);
}

TEST(LasReader, ScalesAndShiftsInDoublePrecision) {
  const Asset asset = test::checked(parse_las, two_points());
  EXPECT_EQ(asset.format, "las");
  EXPECT_EQ(asset.up, 3);
  EXPECT_EQ(asset.unit, 0);
  ASSERT_EQ(asset.points->position.size(), 2u);
  EXPECT_EQ(asset.points->position[0], (Vec3{8e5 + 0.01 * 123, -11, 6}));
  EXPECT_EQ(asset.points->position[1], (Vec3{8e5 + 0.01 * 124, -9, -2}));
}

TEST(LasReader, TakesColoursOf16AndOf8Bits) {
  EXPECT_EQ(parse_las(two_points(65535), "file").points->colour.at(0),
            (std::array<float, 4>{1, 0, 1, 1}));
  EXPECT_EQ(parse_las(two_points(255), "file").points->colour.at(0),
            (std::array<float, 4>{1, 0, 1, 1}));
  // sRGB 188 / 255 in linear light
  EXPECT_NEAR(parse_las(two_points(188), "file").points->colour.at(0)[0], 0.5028865, 1e-6);
}

TEST(LasReader, ReadsEveryPointFormat) {
  const int bytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  const int colour[] = {0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
  for (int format = 0; format <= 10; ++format) {
    const int n = bytes[format] + 3;  // of extra bytes
    std::string points = record_of(n, 1, 2, 3) + record_of(n, 4, 5, 6);
    if (colour[format] > 0) points = with(points, size_t(colour[format]), uint16_t(0xffff));
    const std::string old = header_of(3, format, n, 2) + points;
    const std::string header14 = header_of(4, format, n, 0);
    for (const std::string& file : {old, with(header14, kPoints14, uint64_t(2)) + points}) {
      const PointCloud cloud = *test::checked(parse_las, file).points;
      EXPECT_EQ(cloud.position.at(1), (Vec3{8e5 + 0.04, -9.9, 5})) << format;
      ASSERT_EQ(cloud.colour.size(), colour[format] > 0 ? 2u : 0u) << format;
      for (const auto& c : cloud.colour)
        EXPECT_EQ(c, (std::array<float, 4>{float(&c == &cloud.colour[0]), 0, 0, 1})) << format;
    }
  }
}

TEST(LasReader, RefusesWhatCannotBe) {
  const std::string file = two_points();
  const std::string header14 = header_of(4, 3, 34, 0);
  const std::pair<std::string, std::string> cases[] = {
      // headers
      {"", "has no LAS header"},
      {with(file, 0, uint8_t('X')), "has no LAS header"},
      {with(file, 24, uint8_t(2)), "LAS 2.2 is not read"},
      {with(file, 25, uint8_t(5)), "LAS 1.5 is not read"},
      {with(file, kFormat, uint8_t(131)), "(LAZ) are not read; laszip or las2las"},
      {with(file, kFormat, uint8_t(11)), "the point format 11 is not read"},
      // records and counts
      {with(file, kRecordBytes, uint16_t(33)), "points of the format 3 take 34 bytes, not 33"},
      {with(file, kRecordBytes, uint16_t(0)), "take 34 bytes, not 0"},
      {with(file, kPoints, uint32_t(3)), "3 points are claimed but only 68 bytes are left"},
      {with(file, kPoints, uint32_t(0x80000000)), "2147483648 points are claimed"},
      {with(header14, kPoints14, ~uint64_t(0)), "claims 18446744073709551615 points"},
      {with(header14, kPoints14, uint64_t(1)), "1 points are claimed but only 0 bytes"},
      {with(file, 96, uint32_t(3)), "its points begin at byte 3"},
      {with(file, 96, ~uint32_t(0)), "its points begin at byte 4294967295"},
      // points
      {header_of(2, 3, 34, 0), "has no points: nothing to simulate"},
      {with(file, 131, double(NAN)), "none of its 2 points is finite"},
      {with(file, 131, 0., 0., 0.), "all its points lie in one place"},
  };
  for (const auto& [bytes, message] : cases)
    expect_says(error_of([&, &b = bytes] { test::checked(parse_las, b); }), message);
}

TEST(LasReader, NoCutAndNoByteBreaksIt) {
  test::expect_no_cut_is_read(parse_las, two_points());
  test::expect_any_byte_is_read_or_refused(parse_las, two_points());
}

TEST(LasReader, ReadsARealFileWithItsCount) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  const PointCloud cloud = *read_las(folder + "points/simple.las").points;
  EXPECT_EQ(cloud.position.size(), 1065u);
  EXPECT_EQ(cloud.colour.size(), 1065u);
  Box box;
  for (const Vec3& p : cloud.position) box.add(p);
  EXPECT_NEAR(box.extent(0), 3.36e3, 5);
  EXPECT_NEAR(box.extent(1), 4.64e3, 5);
  EXPECT_NEAR(box.extent(2), 180, 0.5);
}

/// Value of an own column of the first point.
template <class T>
T own_value(const OwnColumns& own, const std::string& name) {
  size_t at = 0;
  for (const OwnColumns::Column& column : own.columns) {
    T value = {};
    if (column.name == name) std::memcpy(&value, own.rows.data() + at, sizeof(T));
    if (column.name == name) return value;
    at += size_t(size_of(column.type));
  }
  ADD_FAILURE() << name;
  return {};
}

TEST(LasReader, CarriesTheAttributesOfPoints) {
  // by the tables of the standard: formats 0 to 5 and 6 to 10
  std::string old = with(record_of(28, 1, 2, 3), 12, uint16_t(40000));
  old = with(old, 14, uint8_t(3 | 5 << 3 | 1 << 6), uint8_t(9 | 2 << 5), int8_t(-20), uint8_t(77));
  old = with(old, 18, uint16_t(1234), 5.5);
  const Asset a = test::checked(parse_las, header_of(2, 1, 28, 2) + old + record_of(28, 9, 9, 9));
  const OwnColumns& own = a.points->own;
  EXPECT_EQ(own_value<uint16_t>(own, "intensity"), 40000);
  EXPECT_EQ(own_value<uint8_t>(own, "return_number"), 3);
  EXPECT_EQ(own_value<uint8_t>(own, "number_of_returns"), 5);
  EXPECT_EQ(own_value<uint8_t>(own, "scan_direction"), 1);
  EXPECT_EQ(own_value<uint8_t>(own, "edge_of_flight_line"), 0);
  EXPECT_EQ(own_value<uint8_t>(own, "classification"), 9);
  EXPECT_EQ(own_value<uint8_t>(own, "classification_flags"), 2);
  EXPECT_EQ(own_value<int8_t>(own, "scan_angle"), -20);
  EXPECT_EQ(own_value<uint8_t>(own, "user_data"), 77);
  EXPECT_EQ(own_value<uint16_t>(own, "point_source_id"), 1234);
  EXPECT_EQ(own_value<double>(own, "gps_time"), 5.5);
  EXPECT_EQ(test::finding_of(a, "lost-columns"), 0);

  std::string fresh = with(record_of(40, 1, 2, 3), 14, uint8_t(11 | 12 << 4), uint8_t(5 | 2 << 4),
                           uint8_t(200), uint8_t(7), int16_t(-3000), uint16_t(8), 2.25);
  fresh = with(fresh, 36, uint16_t(50000));
  const Asset b = test::checked(parse_las, header_of(4, 8, 40, 2) + fresh + record_of(40, 9, 9, 9));
  EXPECT_EQ(own_value<uint8_t>(b.points->own, "number_of_returns"), 12);
  EXPECT_EQ(own_value<uint8_t>(b.points->own, "scanner_channel"), 2);
  EXPECT_EQ(own_value<uint8_t>(b.points->own, "classification"), 200);
  EXPECT_EQ(own_value<int16_t>(b.points->own, "scan_angle"), -3000);
  EXPECT_EQ(own_value<double>(b.points->own, "gps_time"), 2.25);
  EXPECT_EQ(own_value<uint16_t>(b.points->own, "nir"), 50000);
  EXPECT_EQ(test::finding_of(b, "lost-columns"), 1);  // two extra bytes a point
}

}  // namespace
}  // namespace elastogen
