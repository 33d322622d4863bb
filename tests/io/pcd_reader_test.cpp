// SPDX-License-Identifier: Apache-2.0
#include "io/pcd_reader.hpp"

#include "io/lzf.hpp"
#include "tests/io/cloud_files.hpp"

namespace elastogen {
namespace {

using test::bytes_of;
using test::error_of;
using test::expect_says;

std::string header_of(const std::string& data, int64_t points, const char* fields = "x y z rgb") {
  return concat("# .PCD v0.7 - made by a test\nVERSION 0.7\nFIELDS ", fields,
                "\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH ", points,
                "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ", points, "\nDATA ", data, "\n");
}

/// Three points, the second a gap of an organised cloud.
const std::string kText = header_of("ascii", 3) + "0 0.5 1 16711680\nnan nan nan 0\n2 3 4 255\n";
const std::string kBinary = header_of("binary", 3) + bytes_of(0.f, 0.5f, 1.f, 0xff0000u) +
                            bytes_of(NAN, 0.f, 0.f, 0u) + bytes_of(2.f, 3.f, 4.f, 0xffu);

/// The points of kBinary, field by field, packed without a saving: runs of 24 bytes.
std::string compressed() {
  const std::string values =
      bytes_of(0.f, NAN, 2.f, 0.5f, 0.f, 3.f, 1.f, 0.f, 4.f) + bytes_of(0xff0000u, 0u, 0xffu);
  const std::string packed = '\x17' + values.substr(0, 24) + '\x17' + values.substr(24);
  return header_of("binary_compressed", 3) +
         bytes_of(uint32_t(packed.size()), uint32_t(values.size())) + packed;
}

TEST(PcdReader, TheThreeEncodingsGiveTheSame) {
  for (const std::string& bytes : {kText, kBinary, compressed(), test::with_mark_and_crlf(kText)}) {
    const Asset asset = test::checked(parse_pcd, bytes);
    EXPECT_EQ(asset.format, "pcd");
    EXPECT_EQ(asset.up, 0);
    EXPECT_EQ(asset.points->position, (std::vector<Vec3>{{0, 0.5, 1}, {2, 3, 4}}));
    EXPECT_EQ(asset.points->colour.at(0), (std::array<float, 4>{1, 0, 0, 1}));
    EXPECT_EQ(asset.points->colour.at(1), (std::array<float, 4>{0, 0, 1, 1}));
    EXPECT_EQ(test::finding_of(asset, "bad-points"), 1);
  }
}

TEST(PcdReader, ReadsNormalsWideFieldsAndSkipsOthers) {
  const std::string head =
      "VERSION .7\nFIELDS normal_x label x y z normal_y normal_z rgba curve\n"
      "SIZE 4 2 8 8 8 4 4 4 4\nTYPE F U F F I F F U F\nCOUNT 1 3 1 1 1 1 1 1 2\nWIDTH 2\n"
      "HEIGHT 1\nDATA binary\n";
  const auto point = [](double x, int64_t z) {
    return bytes_of(0.f, uint16_t(7), uint16_t(8), uint16_t(9), x, 2., z, 0.6f, 0.8f) +
           bytes_of(0x80ff0000u, 1.f, 2.f);
  };
  const PointCloud cloud =
      *parse_pcd(head + point(5648349.895035, -3) + point(1, 4), "file").points;
  EXPECT_EQ(cloud.position, (std::vector<Vec3>{{5648349.895035, 2, -3}, {1, 2, 4}}));
  EXPECT_EQ(cloud.normal.at(0), (std::array<float, 3>{0, 0.6f, 0.8f}));
  EXPECT_EQ(cloud.colour.at(1)[0], 1);
  EXPECT_FLOAT_EQ(cloud.colour.at(1)[3], 128 / 255.f);
}

TEST(PcdReader, ReadsColoursThatAreTheBitsOfAFloat) {
  std::string text = header_of("ascii", 2) + "0 0 0 2.3418052e-38\n1 0 0 0\n";
  text.replace(text.find("TYPE F F F U"), 12, "TYPE F F F F");
  // 0xff0000 as the bits of a float is 2.3418052e-38
  EXPECT_EQ(parse_pcd(text, "file").points->colour.at(0), (std::array<float, 4>{1, 0, 0, 1}));
}

TEST(PcdReader, RefusesWhatCannotBe) {
  // a header or a body with one fault each
  const std::string rows = "0 0 0 0\n1 0 0 0\n";
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = header_of("ascii", 2) + rows;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::pair<std::string, std::string> cases[] = {
      {"", "file:0: the header has no DATA line"},
      {"VERSION 0.7\nnonsense\n", "file:2: unknown header line \"nonsense\""},
      {header_of("zipped", 2) + rows, "DATA must be ascii, binary or binary_compressed"},
      {header_of("ascii", 2, "x y u rgb") + rows, "there are no fields x, y, z"},
      {replaced("SIZE 4", "SIZE 3"), "a value of x has 3 bytes, not 1, 2, 4 or 8"},
      {replaced("SIZE 4", "SIZE 9"), "an integer from 1 to 8 is expected"},
      {replaced("SIZE 4", "SIZE 2"), "a floating number of 2 bytes"},
      {replaced("TYPE F", "TYPE Q"), "file:5: the type of x must be I, U or F"},
      {replaced("COUNT 1", "COUNT 0"), "there are no fields x, y, z"},
      {replaced("COUNT 1", "COUNT -1"), "file:6: an integer from 0 to 65536 is expected"},
      {replaced("WIDTH 2", "WIDTH -2"), "file:7: an integer from 0 to 2147483647"},
      {replaced("WIDTH 2", "WIDTH 3"), "WIDTH times HEIGHT is 3, POINTS is 2"},
      {replaced("POINTS 2", "POINTS 2147483648"), "file:10: an integer from 0 to 2147483647"},
      {header_of("ascii", 2147483647) + rows, "2147483647 points are claimed but only 16 bytes"},
      {header_of("binary", 2147483647) + rows, "2147483647 points are claimed but only 16 bytes"},
      {header_of("ascii", 3) + rows, "file:13: 3 points are claimed but only 2 lines follow"},
      {header_of("ascii", 2) + "0 0 0 0\n1 0 0\n", "file:13: a number is expected, not \"\""},
      {header_of("ascii", 2) + "0 0 0 0\n1 0 x 0\n", "file:13: a number is expected, not \"x\""},
      {header_of("binary_compressed", 2) + bytes_of(9u), "bytes of a value are claimed"},
      {header_of("binary_compressed", 2) + bytes_of(9u, 32u), "9 compressed bytes are claimed"},
      {header_of("binary_compressed", 2) + bytes_of(1u, 32u, '\0'), "points are damaged"},
      {header_of("binary_compressed", 2) + bytes_of(1u, ~0u, '\0'), "points are damaged"},
      {header_of("binary_compressed", 2) + bytes_of(2u, 1u, '\0', 'a'), "2 points are claimed"},
      {header_of("ascii", 0), "has no points: nothing to simulate"},
      {header_of("binary", 0), "has no points: nothing to simulate"},
  };
  for (const auto& [text, message] : cases)
    expect_says(error_of([&, &t = text] { test::checked(parse_pcd, t); }), message);
}

TEST(PcdReader, RefusesTooManyFields) {
  std::string fields = "FIELDS";
  for (int k = 0; k < 300; ++k) fields += " f";
  expect_says(error_of([&] { parse_pcd(fields + "\n", "file"); }), "more than 256 fields");
}

TEST(PcdReader, NoCutAndNoByteBreaksIt) {
  test::expect_no_cut_is_read(parse_pcd, kText, 3);
  for (const std::string& bytes : {kBinary, compressed()})
    test::expect_no_cut_is_read(parse_pcd, bytes);
  for (const std::string& bytes : {kText, kBinary, compressed()})
    test::expect_any_byte_is_read_or_refused(parse_pcd, bytes);
}

TEST(PcdReader, ReadsARealFileWithItsCount) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  Asset asset = read_pcd(folder + "points/Zaghetto.pcd");
  check_asset(asset);
  EXPECT_EQ(asset.points->position.size(), 59750u);
  EXPECT_TRUE(asset.findings.empty());
}

TEST(Lzf, UnpacksRunsAndCopies) {
  // three bytes as they are, then copies: 4 from 3 back (overlapping), 9 + 1 from 1 back
  const std::string packed = std::string("\x02") + "abc" + '\x40' + '\x02' + '\xe0' + '\x01' + '\0';
  EXPECT_EQ(lzf_unpacked(packed, 17), "abcabca" + std::string(10, 'a'));
  EXPECT_EQ(lzf_unpacked("", 0), "");
  // a distance of more than a byte: 300 bytes, then the first four again
  std::string far, plain;
  for (int k = 0; k < 300; ++k) plain += char('a' + k % 23);
  for (size_t k = 0; k < 300; k += 30) far += '\x1d' + plain.substr(k, 30);
  far += '\x41';  // two more than 2, high bits 1: back 256 + 43 + 1
  far += char(43);
  EXPECT_EQ(lzf_unpacked(far, 304), plain + plain.substr(0, 4));
}

TEST(Lzf, RefusesWhatIsDamaged) {
  const std::string packed = std::string("\x02") + "abc" + '\x40' + '\x02';
  EXPECT_TRUE(lzf_unpacked(packed, 7));
  for (size_t n = 0; n < packed.size(); ++n) EXPECT_FALSE(lzf_unpacked(packed.substr(0, n), 7));
  EXPECT_FALSE(lzf_unpacked(packed, 6));                      // too much
  EXPECT_FALSE(lzf_unpacked(packed, 8));                      // too little
  EXPECT_FALSE(lzf_unpacked(std::string("\x20\x00", 2), 3));  // before the beginning
  EXPECT_FALSE(lzf_unpacked(packed, size_t(1) << 40));        // more than it could give
}

TEST(PcdReader, CarriesFieldsOfItsOwn) {
  const std::string head =
      "VERSION .7\nFIELDS x y z intensity ring stamp pair _\nSIZE 4 4 4 4 2 8 1 1\n"
      "TYPE F F F F U U I U\nCOUNT 1 1 1 1 1 1 2 3\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n";
  const std::string expected = test::bytes_of(0.5f, uint16_t(60000), int8_t(-1), int8_t(2), 1.5f,
                                              uint16_t(3), int8_t(4), int8_t(-5));
  const std::string text = "DATA ascii\n1 2 3 .5 60000 1 -1 2 0 0 0\n4 5 6 1.5 3 2 4 -5 0 0 0\n";
  const std::string binary =
      "DATA binary\n" +
      test::bytes_of(1.f, 2.f, 3.f, 0.5f, uint16_t(60000), uint64_t(1), int8_t(-1), int8_t(2),
                     uint8_t(0), uint8_t(0), uint8_t(0)) +
      test::bytes_of(4.f, 5.f, 6.f, 1.5f, uint16_t(3), uint64_t(2), int8_t(4), int8_t(-5),
                     uint8_t(0), uint8_t(0), uint8_t(0));
  for (const std::string& data : {text, binary}) {
    const Asset asset = test::checked(parse_pcd, head + data);
    const OwnColumns& own = asset.points->own;
    ASSERT_EQ(own.columns.size(), 4u);
    EXPECT_EQ(own.columns[0].name, "intensity");
    EXPECT_EQ(own.columns[3].name, "pair_1");
    EXPECT_EQ(own.rows, expected);
    EXPECT_EQ(test::finding_of(asset, "carried-columns"), 4);
    EXPECT_EQ(test::finding_of(asset, "lost-columns"), 1);  // an integer of 64 bits
  }
}

}  // namespace
}  // namespace elastogen
