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

TEST(OffReader, SkipsColoursAndKeepsNormals) {
  const Asset coloured = parse_off(
      "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2 0.5 0.5 1\n",
      "file");
  EXPECT_EQ(coloured.meshes[0].position[1], (Vec3{1, 0, 0}));
  EXPECT_EQ(coloured.meshes[0].groups[0].corner, (std::vector<int32_t>{0, 1, 2}));
  for (const char* keyword : {"NOFF", "CNOFF", "STCNOFF"}) {
    const Asset asset = parse_off(
        concat(keyword, "\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0.6 0.8\n3 0 1 2\n"), "file");
    EXPECT_EQ(asset.meshes[0].normal.at(2), (std::array<float, 3>{0, 0.6f, 0.8f}));
  }
}

TEST(OffReader, RefusesWhatCannotBe) {
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  const std::pair<std::string, std::string> cases[] = {
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
      {"OFF\n3 1 0\n" + points, "file:5: the file ends where a face"},
      {"OFF\n3 1 0\n0 0\n1 0 0\n0 1 0\n3 0 1 2", "file:3: a number is expected, not \"\""},
      {"OFF\n3 1 0\n0 0 z\n1 0 0\n0 1 0\n3 0 1 2", "file:3: a number is expected, not \"z\""},
      {"OFF\n3 1 0\n" + points + "3 0 1 3\n", "file:6: an index of a vertex must be an integer"},
      {"OFF\n3 1 0\n" + points + "3 0 1 -1\n", "from 0 to 2, not \"-1\""},
      {"OFF\n3 1 0\n" + points + "3 0 1\n", "file:6: an index of a vertex"},
      {"OFF\n3 1 0\n" + points + "2147483646 0 1 2\n", "file:6: the number of corners"},
      {"OFF\n3 1 0\n" + points + "-3 0 1 2\n", "the number of corners"},
      {"OFF\n3 0 0\n" + points, "nothing to simulate"},
      {"OFF\n0 0 0\n", "nothing to simulate"},
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
