// SPDX-License-Identifier: Apache-2.0
#include "io/xyz_reader.hpp"

#include "tests/io/cloud_files.hpp"

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

PointCloud parsed_xyz(const std::string& text) {
  return *parse_xyz(text, "file").points;
}

TEST(XyzReader, TakesAnySeparatorMarkAndLineEnd) {
  const std::vector<Vec3> expected = {{1, 2, 3}, {-4.5, 0, 6e-3}};
  for (const std::string text :
       {"1 2 3\n-4.5 0 6e-3", "1,2,3\n-4.5,0,6e-3\n", "1;2;3\n-4.5;0;6e-3\n",
        "\n1\t2\t3\n\n# a comment\n // another\n-4.5\t0\t6e-3\n\n", "1, 2, 3\n -4.5 ,0 , 6e-3\n"}) {
    EXPECT_EQ(parsed_xyz(text).position, expected) << text;
    EXPECT_EQ(parsed_xyz(test::with_mark_and_crlf(text)).position, expected) << text;
  }
}

TEST(XyzReader, KeepsTheDigitsOfLargeCoordinates) {
  EXPECT_EQ(parsed_xyz("665187.522077 5648349.895035 241.767693\n0 0 0\n").position[0],
            (Vec3{665187.522077, 5648349.895035, 241.767693}));
}

TEST(XyzReader, TellsColoursFromNormals) {
  const PointCloud bytes = parsed_xyz("0 0 0 255 0 188\n1 0 0 10 20 30\n");
  EXPECT_TRUE(bytes.normal.empty());
  EXPECT_EQ(bytes.colour.at(0)[0], 1);
  EXPECT_NEAR(bytes.colour.at(0)[2], 0.5028865, 1e-6);  // sRGB 188 / 255 in linear light
  EXPECT_EQ(bytes.colour.at(0)[3], 1);
  const PointCloud shares = parsed_xyz("0 0 0 1 0 0.5\n1 0 0 0.1 0.2 0.3\n");
  EXPECT_NEAR(shares.colour.at(0)[2], 0.2140411, 1e-6);  // sRGB 1/2
  const PointCloud normals = parsed_xyz("0 0 0 0 0.6 0.8\n1 0 0 -1 0 0\n");
  EXPECT_TRUE(normals.colour.empty());
  EXPECT_EQ(normals.normal.at(1), (std::array<float, 3>{-1, 0, 0}));
  const PointCloud both = parsed_xyz("0 0 0 9 0 0 0 0.6 0.8\n1 0 0 0 7 0 -1 0 0\n");
  EXPECT_EQ(both.normal.size(), 2u);
  EXPECT_EQ(both.colour.size(), 2u);
  const PointCloud neither = parsed_xyz("0 0 0 -3 4 900\n1 0 0 1 2 3\n");
  EXPECT_TRUE(neither.colour.empty() && neither.normal.empty());
}

TEST(XyzReader, TakesNamesOfColumns) {
  for (const char* head : {"nx ny nz z y x", "#NX NY NZ Z Y X", "//nx,ny,nz,z,y,x"}) {
    const PointCloud cloud = parsed_xyz(concat(head, "\n0 0 2 3 2 1\n0 0 1 6 5 4\n"));
    EXPECT_EQ(cloud.position, (std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}})) << head;
    EXPECT_EQ(cloud.normal.at(0), (std::array<float, 3>{0, 0, 2})) << head;
  }
  const PointCloud cloud = parsed_xyz("//X Y Z R G B Scalar\n0 0 0 51 102 255 7\n1 1 1 0 0 1 8\n");
  EXPECT_NEAR(cloud.colour.at(0)[0], 0.0331048, 1e-6);  // sRGB 1/5
}

TEST(XyzReader, TakesANumberOfPointsAndSkipsIntensities) {
  const PointCloud cloud = parsed_xyz("2\n0 0 0 -100 255 0 0\n1 0 0 50 0 255 0\n");
  EXPECT_EQ(cloud.position.size(), 2u);
  EXPECT_EQ(cloud.colour.at(0)[0], 1);
  EXPECT_EQ(cloud.colour.at(1)[1], 1);
}

TEST(XyzReader, DropsAndCountsPointsThatAreNotFinite) {
  const Asset asset = test::checked(
      parse_xyz, "0 0 0 1 0 0\nnan 0 0 0 1 0\n2 0 0 0 0 1\n3 inf 0 0 0 1\n1e999 0 0 0 0 1\n");
  EXPECT_EQ(asset.points->position, (std::vector<Vec3>{{0, 0, 0}, {2, 0, 0}}));
  EXPECT_EQ(asset.points->normal.at(1), (std::array<float, 3>{0, 0, 1}));
  EXPECT_EQ(test::finding_of(asset, "bad-points"), 3);
  expect_says(asset.findings[0].text, "the first is number 1 (counted from 0)");
}

TEST(XyzReader, RefusesWithTheLine) {
  const std::pair<std::string, std::string> cases[] = {
      // rows and words
      {"0 0 0\n1 0\n", "file:2: a point has three numbers, not 2"},
      {"0 0 0\n1\n", "file:2: a point has three numbers, not 1"},
      {"0 0 0\n\n1 0 0 4\n", "file:3: the first point has 3 columns, this one 4"},
      {"hello world\n0 0 0\n", "file:1: a point has three numbers, not 2"},
      {"some words here\n0 0 0\n", "file:1: a number is expected, not \"some\""},
      {"0 0 0\n1 0 0x10\n", "file:2: a number is expected, not \"0x10\""},
      {"1,5;2,5;3,5\n", "file:1: commas and semicolons: write decimal points"},
      // first lines
      {"x y z r g b\n0 0 0\n", "file:2: the first line names more columns"},
      {"3\n0 0 0\n1 0 0\n", "the first line says 3 points, the file has 2"},
      {"2147483648\n0 0 0\n1 0 0\n", "says 2147483648 points, the file has 2"},
      {"-5\n0 0 0\n", "a point has three numbers"},
      {"0 0 0\n1 0 \xff\n", "file:2: a number is expected"},
      {std::string("0 0 0\n1 0 \0\n", 12), "file:2: a number is expected"},
      {[] {
         std::string row;
         for (int k = 0; k < 1000; ++k) row += "1 ";
         return row;
       }(),
       "file:1: more than 64 columns"},
      // points
      {"", "has no points: nothing to simulate"},
      {"x y z\n", "has no points: nothing to simulate"},
      {"0\n", "has no points: nothing to simulate"},
      {"nan nan nan\n", "none of its 1 points is finite: nothing to simulate"},
      {"1 2 3\n1 2 3\n", "all its points lie in one place"},
      {"1e300 0 0\n0 0 0\n", "is out of range"},
  };
  for (const auto& [text, message] : cases)
    expect_says(error_of([&, &t = text] { test::checked(parse_xyz, t); }), message);
}

TEST(XyzReader, NoCutAndNoByteBreaksIt) {
  const std::string text = "3\n0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n";
  test::expect_no_cut_is_read(parse_xyz, text, 1);
  test::expect_any_byte_is_read_or_refused(parse_xyz, text);
}

TEST(XyzReader, ReadsRealFilesWithTheirCounts) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  const PointCloud scan = *read_xyz(folder + "points/spot_half_scan.xyz").points;
  EXPECT_EQ(scan.position.size(), 8000u);
  EXPECT_TRUE(scan.colour.empty() && scan.normal.empty());
  const PointCloud coloured = *read_xyz(folder + "points/cloudcompare.xyz").points;
  EXPECT_EQ(coloured.position.size(), 101u);
  EXPECT_EQ(coloured.position[0][1], 5648349.895035);
  EXPECT_EQ(coloured.colour.size(), 101u);
}

TEST(XyzReader, CarriesColumnsOfItsOwn) {
  const Asset named = test::checked(
      parse_xyz, "x y z label red green blue who\n1 2 3 7 255 0 0 me\n4 5 6 -0.1 0 0 0 you\n");
  const OwnColumns& own = named.points->own;
  ASSERT_EQ(own.columns.size(), 1u);
  EXPECT_EQ(own.columns[0].name, "label");
  EXPECT_EQ(own.rows, test::bytes_of(7., -0.1));
  EXPECT_EQ(named.points->colour.size(), 2u);
  EXPECT_EQ(test::finding_of(named, "carried-columns"), 1);
  EXPECT_EQ(test::finding_of(named, "lost-columns"), 1);  // words
  const Asset plain = test::checked(parse_xyz, "1 2 3 -5\n4 5 6 0.5\nnan 0 0 9\n1 1 1 8\n");
  EXPECT_EQ(plain.points->own.columns.at(0).name, "column_4");
  EXPECT_EQ(plain.points->own.rows, test::bytes_of(-5., 0.5, 8.));  // without the bad point
  const Asset pts = test::checked(parse_xyz, "2\n1 2 3 -200 255 0 0\n4 5 6 9 0 0 0\n");
  EXPECT_EQ(pts.points->own.columns.at(0).name, "intensity");
  EXPECT_EQ(pts.points->own.rows, test::bytes_of(-200., 9.));
}

}  // namespace
}  // namespace elastogen
