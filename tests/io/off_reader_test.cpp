// SPDX-License-Identifier: Apache-2.0
#include "io/off_reader.hpp"

#include "tests/io/cloud_files.hpp"

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

/// Half an octahedron: four triangles of which two are given as a quad each.
const std::string kPyramid =
    "OFF\n# made by a test\n5 5 8\n\n0 0 0\n1 0 0 # a corner\n1 1 0\n0 1 0\n0.5 0.5 1\n"
    "4 3 2 1 0\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";

std::string message_of(const std::string& text) {
  return error_of([&] { test::checked(parse_off, text); });
}

TEST(OffReader, ReadsVerticesAndFacesInOrder) {
  for (const std::string& text : {kPyramid, test::with_mark_and_crlf(kPyramid)}) {
    const Asset asset = test::checked(parse_off, text);
    const Mesh& mesh = asset.meshes.at(0);
    EXPECT_EQ(asset.format, "off");
    EXPECT_EQ(mesh.position.size(), 5u);
    EXPECT_EQ(mesh.position[4], (Vec3{0.5, 0.5, 1}));
    EXPECT_EQ(mesh.groups.at(0).corner,
              (std::vector<int32_t>{3, 2, 1, 3, 1, 0, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4}));
    EXPECT_NEAR(weld(pose_surface(asset)).volume, 1. / 3, 1e-15);
  }
}

TEST(OffReader, TakesCountsBesideAndGluedToTheKeyword) {
  const std::string rest = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (const char* head : {"OFF 3 1 0\n", "OFF3 1 0\n", "OFF\n3 1\n", "# c\nOFF\n\n 3 1 0 \n"})
    EXPECT_EQ(parse_off(head + rest, "file").meshes[0].groups[0].corner.size(), 3u) << head;
}

TEST(OffReader, KeepsNormals) {
  for (const char* keyword : {"NOFF", "CNOFF", "STCNOFF"}) {
    const Asset asset = parse_off(
        concat(keyword, "\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0.6 0.8\n3 0 1 2\n"), "file");
    EXPECT_EQ(asset.meshes[0].normal.at(2), (std::array<float, 3>{0, 0.6f, 0.8f}));
  }
}

TEST(OffReader, ColoursAndCoordinatesFollowTheKeyword) {
  // 188 / 255 of sRGB is 0.5028865 in linear light; floats are shares of the same
  const std::pair<const char*, const char*> colours[] = {{"255 0 188 51", "255 188 0"},
                                                         {"1 0 0.737255 0.2", "1. 0.737255 0"}};
  for (const auto& [four, three] : colours)
    for (const bool uv : {false, true})
      for (const bool normal : {false, true}) {
        std::string text = concat(uv ? "ST" : "", "C", normal ? "N" : "", "OFF\n3 1 0\n");
        for (const char* x : {"0 0 0", "1 0 0", "0 1 0"})
          text += concat(x, normal ? " 0 0 1 " : " ", x[0] == '1' ? three : four,
                         uv ? " 0.25 0.75\n" : "\n");
        const Mesh mesh = test::checked(parse_off, text + "3 0 1 2\n").meshes.at(0);
        ASSERT_EQ(mesh.colour.size(), 3u);
        EXPECT_EQ(mesh.colour[0][0], 1);
        EXPECT_NEAR(mesh.colour[0][2], 0.5028865, 1e-5);
        EXPECT_NEAR(mesh.colour[0][3], 0.2, 1e-6);
        EXPECT_NEAR(mesh.colour[1][1], 0.5028865, 1e-5);
        EXPECT_EQ(mesh.colour[1][3], 1);  // opaque where the file does not say
        EXPECT_EQ(mesh.uv.size(), uv ? 3u : 0u);
        if (uv) {
          EXPECT_EQ(mesh.uv[1], (std::array<float, 2>{0.25f, 0.25f}));
        }
        EXPECT_EQ(mesh.normal.size(), normal ? 3u : 0u);
      }
}

TEST(OffReader, ColoursOfFacesSplitTheirVertices) {
  for (const char* red : {"255 0 0", "255 0 0 255", "1.0 0 0", "1 0 0 1"}) {
    const Asset asset = test::checked(
        parse_off, concat("OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 ", red, "\n3 0 2 3\n"));
    const Mesh& mesh = asset.meshes.at(0);
    EXPECT_EQ(mesh.position.size(), 4u);
    ASSERT_EQ(mesh.position_of, (std::vector<int32_t>{0, 1, 2, 3, 0, 2})) << red;
    const std::vector<int32_t>& corner = mesh.groups.at(0).corner;
    for (size_t k = 0; k < 6; ++k)
      EXPECT_EQ(mesh.colour[size_t(corner[k])],
                k < 3 ? (std::array<float, 4>{1, 0, 0, 1}) : (std::array<float, 4>{1, 1, 1, 1}))
          << red;
  }
  const Asset both = parse_off(
      "COFF\n3 1 0\n0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 0\n3 0 1 2 0 255 0\n", "file");
  EXPECT_EQ(both.meshes[0].colour.at(0), (std::array<float, 4>{1, 0, 0, 1}));
  EXPECT_EQ(test::finding_of(both, "face-colours"), 1);
  const Asset table = parse_off("OFF\n3 1 0\n0 0 0 9 9\n1 0 0\n0 1 0\n3 0 1 2 7\n", "file");
  EXPECT_TRUE(table.meshes[0].colour.empty());
  EXPECT_EQ(test::finding_of(table, "left-out-properties"), 2);
}

TEST(OffReader, RefusesWhatCannotBe) {
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  const std::pair<std::string, std::string> cases[] = {
      // keyword and counts
      {"", "file:0: the file ends where OFF"},
      {"# only\n\n", "the file ends where OFF"},
      {"3 1 0\n" + points, "file:1: an OFF file begins with OFF"},
      {"OFF BINARY\n", "binary OFF is not read; save it as text"},
      {"4OFF\n", "another dimension"},
      {"nOFF\n4\n", "another dimension"},
      {"OFF\n", "file:1: the file ends where counts"},
      {"OFF\n-3 1 0\n" + points, "the number of vertices must be an integer from 0"},
      {"OFF\n3 1.5 0\n" + points, "the number of faces must be an integer"},
      {"OFF\n99999999999999999999 1 0\n", "the number of vertices must be an integer"},
      {"OFF\n2147483648 1 0\n" + points, "the number of vertices must be an integer"},
      {"OFF\n2000000000 1 0\n" + points, "2000000000 vertices and 1 faces are claimed"},
      {"OFF\n3 2000000000 0\n" + points, "are claimed but only 18 bytes follow"},
      // vertices and faces
      {"OFF\n3 1 0\n" + points, "file:5: the file ends where a face"},
      {"OFF\n3 1 0\n0 0\n1 0 0\n0 1 0\n3 0 1 2", "file:3: a number is expected, not \"\""},
      {"OFF\n3 1 0\n0 0 z\n1 0 0\n0 1 0\n3 0 1 2", "file:3: a number is expected, not \"z\""},
      {"OFF\n3 1 0\n" + points + "3 0 1 3\n", "file:6: an index of a vertex must be an integer"},
      {"OFF\n3 1 0\n" + points + "3 0 1 -1\n", "from 0 to 2, not \"-1\""},
      {"OFF\n3 1 0\n" + points + "3 0 1\n", "file:6: an index of a vertex"},
      {"OFF\n3 1 0\n" + points + "2147483646 0 1 2\n", "file:6: the number of corners"},
      {"OFF\n3 1 0\n" + points + "-3 0 1 2\n", "the number of corners"},
      // empty meshes
      {"OFF\n3 0 0\n" + points, "nothing to simulate"},
      {"OFF\n0 0 0\n", "nothing to simulate"},
      // attributes and numbers
      {"COFF\n3 1 0\n0 0 0 1 1\n1 0 0\n0 1 0\n3 0 1 2\n", "file:3: a vertex has 2 numbers"},
      {"STOFF\n3 1 0\n0 0 0 1\n1 0 0\n0 1 0\n3 0 1 2\n", "two of a texture are expected"},
      {"OFF\n3 1 0\n" + points + "3 0 1 2 red\n", "file:6: a face's colour"},
      {"OFF\n3 1 0\n" + points + "3 0 1 2 1 1 1 1 1\n", "file:6: a face's colour"},
      {"OFF\n3 1 0\nnan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "vertex 0 (counted from 0) is not finite"},
  };
  for (const auto& [text, message] : cases) expect_says(message_of(text), message);
}

TEST(OffReader, RefusesFacesOfTooManyCorners) {
  expect_says(message_of("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n65537 0 1 2\n"), "from 0 to 65536");
}

TEST(OffReader, ReportsFacesOfTwoCorners) {
  const Asset asset = parse_off("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n", "file");
  EXPECT_EQ(test::finding_of(asset, "short-face"), 1);
}

TEST(OffReader, NoCutAndNoByteBreaksIt) {
  test::expect_no_cut_is_read(parse_off, kPyramid, 1);
  test::expect_any_byte_is_read_or_refused(parse_off, kPyramid);
  test::expect_any_byte_is_read_or_refused(
      parse_off,
      "STCNOFF\n3 1 0\n0 0 0 0 0 1 255 0 9 1 0 0\n1 0 0 0 0 1 1 2 3 1 1 0\n"
      "0 1 0 0 0 1 4 5 6 7 0 1\n3 0 1 2 0.5 0.25 1\n");
}

TEST(OffReader, ReadsRealFilesWithTheirCounts) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  const Surface cactus = pose_surface(read_off(folder + "closed/cactus.off"));
  EXPECT_EQ(cactus.triangles.rows(), 10518);
  EXPECT_EQ(cactus.vertices.rows(), 5261);
  EXPECT_TRUE(weld(cactus).closed());
  EXPECT_NEAR(weld(cactus).volume, 0.0113, 5e-5);
  const Surface disk = pose_surface(read_off(folder + "closed/fandisk.off"));
  EXPECT_EQ(disk.triangles.rows(), 12946);
  EXPECT_EQ(disk.vertices.rows(), 6475);
  EXPECT_NEAR(weld(disk).volume, 1.12, 5e-3);
}

}  // namespace
}  // namespace elastogen
