// SPDX-License-Identifier: Apache-2.0
#include "io/ply_reader.hpp"

#include "io/byte_reader.hpp"
#include "tests/io/cloud_files.hpp"

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

Asset parsed_ply(std::string_view bytes) {
  return parse_ply(bytes, "file.ply");
}

template <class T>
std::string bytes_of(T value, std::endian order) {
  std::string raw(sizeof(T), '\0');
  std::memcpy(raw.data(), &value, sizeof(T));
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  return raw;
}

/// A quad of doubles with colours, an unknown list before the indices, an unknown element.
std::string binary_quad(std::endian order, const char* name) {
  std::string out = std::string("ply\nformat ") + name +
                    " 1.0\ncomment made by a test\nelement vertex 4\nproperty double x\n"
                    "property double y\nproperty double z\nproperty uchar red\n"
                    "property uchar green\nproperty uchar blue\nelement extra 2\n"
                    "property list uchar short junk\nelement face 1\n"
                    "property list uchar float weights\nproperty list uint int vertex_indices\n"
                    "property uchar flags\nend_header\n";
  const double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const auto& c : corner) {
    for (const double x : {c[0], c[1], 2.5}) out += bytes_of(x, order);
    out += {char(255), char(0), char(188)};
  }
  out += bytes_of<uint8_t>(0, order) + bytes_of<uint8_t>(2, order) + bytes_of<int16_t>(7, order) +
         bytes_of<int16_t>(8, order);
  out += bytes_of<uint8_t>(1, order) + bytes_of(0.5f, order) + bytes_of<uint32_t>(4, order);
  for (const int32_t i : {0, 1, 2, 3}) out += bytes_of(i, order);
  return out + "f";
}

constexpr const char* kPlyText =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
    "property float s\nproperty float t\nelement face 2\n"
    "property list uchar int vertex_index\nend_header\n"
    "0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0.25\n1 1 0 0 0 1 1 1\n0 1 0 0 0 1 0 1\n"
    "3 0 1 2\n3 0 2 3\n";

TEST(PlyReader, BothByteOrdersGiveTheSame) {
  const Asset little = parsed_ply(binary_quad(std::endian::little, "binary_little_endian"));
  const Asset big = parsed_ply(binary_quad(std::endian::big, "binary_big_endian"));
  for (const Asset* asset : {&little, &big}) {
    const Mesh& mesh = asset->meshes.at(0);
    EXPECT_EQ(mesh.position,
              (std::vector<Vec3>{{0, 0, 2.5}, {1, 0, 2.5}, {1, 1, 2.5}, {0, 1, 2.5}}));
    EXPECT_EQ(mesh.groups.at(0).corner, (std::vector<int32_t>{0, 1, 2, 0, 2, 3}));
    EXPECT_FLOAT_EQ(mesh.colour.at(3)[0], 1);
    EXPECT_NEAR(mesh.colour[3][2], 0.5028865, 1e-6);  // sRGB 188 / 255 in linear light
    EXPECT_EQ(mesh.colour[3][3], 1);
  }
}

TEST(PlyReader, ReadsTextWithNormalsAndUvs) {
  std::string crlf;
  for (const char c : std::string(kPlyText)) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  for (const std::string& text : {std::string(kPlyText), crlf}) {
    const Asset asset = parsed_ply(text);
    const Mesh& mesh = asset.meshes.at(0);
    EXPECT_EQ(mesh.name, "file");
    EXPECT_EQ(mesh.position.size(), 4u);
    EXPECT_EQ(mesh.normal.at(2), (std::array<float, 3>{0, 0, 1}));
    EXPECT_EQ(mesh.uv.at(1), (std::array<float, 2>{1, 0.75f}));
    EXPECT_EQ(mesh.groups.at(0).corner.size(), 6u);
  }
}

TEST(PlyReader, FacesMayStandBeforeVertices) {
  const Asset asset = parsed_ply(
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n"
      "element vertex 3\nproperty int x\nproperty int y\nproperty int z\nend_header\n"
      "3 2 1 0\n\n0 0 0\n1 0 0\n \n0 1 0");
  EXPECT_EQ(asset.meshes[0].groups[0].corner, (std::vector<int32_t>{2, 1, 0}));
}

TEST(PlyReader, NamesTheTextureOfItsComment) {
  const test::TempFolder folder;
  folder.write("skin.png", "png");
  std::string text = kPlyText;
  text.insert(text.find("element vertex"), "comment TextureFile skin.png\n");
  const Asset asset = read_ply(folder.write("a.ply", text));
  ASSERT_EQ(asset.materials.size(), 1u);
  EXPECT_EQ(std::filesystem::path(asset.materials[0].texture).filename(), "skin.png");
  EXPECT_EQ(asset.meshes[0].groups[0].material, 0);
}

TEST(PlyReader, WithoutFacesItIsACloud) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string rows = "0 0 0 0 0 1 255 0 0\n1 nan 0 1 0 0 0 255 0\n2 0 5 0 1 0 0 0 255\n";
  const std::string faces = "element face 0\nproperty list uchar int vertex_indices\n";
  // no element of faces, or one with no rows
  for (const std::string& between : {std::string(), faces}) {
    const Asset asset = test::checked(parse_ply, head + between + "end_header\n" + rows);
    EXPECT_TRUE(asset.meshes.empty() && asset.nodes.empty() && !asset.splats);
    EXPECT_EQ(asset.points->position, (std::vector<Vec3>{{0, 0, 0}, {2, 0, 5}}));
    EXPECT_EQ(asset.points->normal.at(1), (std::array<float, 3>{0, 1, 0}));
    EXPECT_EQ(asset.points->colour.at(1), (std::array<float, 4>{0, 0, 1, 1}));
    EXPECT_EQ(test::finding_of(asset, "bad-points"), 1);
  }
  test::expect_no_cut_is_read(parse_ply, head + "end_header\n" + rows, 3);
  test::expect_any_byte_is_read_or_refused(parse_ply, head + "end_header\n" + rows);
  const std::string none =
      "ply\nformat ascii 1.0\nelement vertex 0\nproperty int x\n"
      "property int y\nproperty int z\nend_header\n";
  expect_says(error_of([&] { test::checked(parse_ply, none); }), "has no points: nothing");
  expect_says(error_of([] {
                parsed_ply(
                    "ply\nformat ascii 1.0\nelement tristrips 1\n"
                    "property list int int vertex_indices\nend_header\n3 0 1 2\n");
              }),
              "triangle strips are not read");
}

/// A row of squares; the numbers of face and corner give the uvs and the colours of faces.
struct CornerFile {
  std::string text;
  static double u(int face, int corner) { return 0.125 * face + 0.25 * (corner % 2); }
  static double v(int face, int corner) { return 0.0625 * face + 0.5 * (corner / 2); }
  static int shade(int face, int channel) { return 40 * face + 10 * channel; }

  CornerFile(int squares, const std::string& textures, bool colours) {
    text = "ply\nformat ascii 1.0\n" + textures;
    text += concat("element vertex ", 2 * (squares + 1),
                   "\nproperty float x\nproperty float y\nproperty float z\nelement face ", squares,
                   "\nproperty list uchar float texcoord\nproperty int texnumber\n",
                   "property list uchar int vertex_indices\n");
    for (const char* channel : {"red", "green", "blue"})
      if (colours) text += concat("property uchar ", channel, '\n');
    text += "end_header\n";
    for (int k = 0; k <= squares; ++k) text += concat(k, " 0 0\n", k, " 1 0\n");
    for (int f = 0; f < squares; ++f) {
      text += "8";
      for (int c = 0; c < 4; ++c) text += concat(' ', u(f, c), ' ', v(f, c));
      text += concat(' ', f % 2, " 4 ", 2 * f, ' ', 2 * f + 2, ' ', 2 * f + 3, ' ', 2 * f + 1);
      for (int k = 0; k < 3 && colours; ++k) text += concat(' ', shade(f, k));
      text += '\n';
    }
  }
};

/// Triangles of a mesh as (square, corner of it) by their positions.
template <class Visit>
void each_corner(const Mesh& mesh, const Visit& visit) {
  for (const TriangleGroup& group : mesh.groups)
    for (size_t k = 0; k < group.corner.size(); k += 3) {
      double least = 1e9;
      for (size_t c = 0; c < 3; ++c) {
        const auto v = size_t(group.corner[k + c]);
        least = std::min(least, mesh.position[size_t(mesh.position_of[v])][0]);
      }
      for (size_t c = 0; c < 3; ++c) {
        const auto v = size_t(group.corner[k + c]);
        const Vec3& x = mesh.position[size_t(mesh.position_of[v])];
        const bool right = x[0] > least, upper = x[1] > 0;
        visit(int(least), upper ? right ? 2 : 3 : right ? 1 : 0, v, group);
      }
    }
}

TEST(PlyReader, CornersHaveUvsAndFacesColoursOfTheirOwn) {
  const test::TempFolder folder;
  folder.write("a.png", "png");
  folder.write("b c.png", "png");
  const std::string textures = "comment TextureFile a.png\ncomment TextureFile b c.png\n";
  for (const int squares : {1, 2, 5})
    for (const bool colours : {false, true}) {
      const CornerFile file(squares, textures, colours);
      Asset asset = read_ply(folder.write("corners.ply", file.text));
      check_asset(asset);
      const Mesh& mesh = asset.meshes.at(0);
      EXPECT_EQ(mesh.position.size(), 2u * size_t(squares + 1));
      // the positions between two squares are drawn twice
      EXPECT_EQ(mesh.position_of.size(), 4u * size_t(squares));
      for (size_t p = 0; p < mesh.position.size(); ++p) EXPECT_EQ(mesh.position_of[p], int(p));
      int count = 0;
      each_corner(mesh, [&](int f, int c, size_t v, const TriangleGroup& group) {
        ++count;
        EXPECT_EQ(mesh.uv[v], (std::array<float, 2>{float(file.u(f, c)), float(1 - file.v(f, c))}));
        EXPECT_EQ(asset.materials[size_t(group.material)].name, f % 2 ? "b c.png" : "a.png");
        for (size_t k = 0; k < 3 && colours; ++k)
          EXPECT_NEAR(srgb_from_linear(mesh.colour[v][k]), file.shade(f, int(k)) / 255., 1e-5);
      });
      EXPECT_EQ(count, 6 * squares);
      EXPECT_EQ(mesh.colour.empty(), !colours);
      EXPECT_EQ(test::finding_of(asset, "left-out-properties"), 0);
    }
}

TEST(PlyReader, CoordinatesThatDoNotFitTheirFaceAreRefusedAndNoneAreNone) {
  std::string text = CornerFile(2, "", false).text;
  const size_t row = text.find("8 0.125");
  ASSERT_NE(row, text.npos);
  std::string few = text;
  few.replace(row, 7, "7");
  expect_says(error_of([&] { parsed_ply(few); }),
              "face 1 has 7 texture coordinates, 8 are expected: two a corner");
  std::string none = text;
  none.replace(row, text.find(" 1 4 2", row) - row, "0");
  const Mesh mesh = parsed_ply(none).meshes.at(0);
  ASSERT_EQ(mesh.groups.size(), 2u);
  EXPECT_TRUE(mesh.groups[0].has_uv);
  EXPECT_FALSE(mesh.groups[1].has_uv);
  EXPECT_EQ(mesh.groups[1].corner.size(), 6u);
}

TEST(PlyReader, WhatIsNotUnderstoodIsKeptOrSaid) {
  // an unknown header line, properties, a list, an element, and bytes behind the end
  std::string text = kPlyText;
  text.insert(text.find("element vertex"), "Made by an old exporter, www.example.org\n");
  text.insert(text.find("element face"),
              "property uchar label\nproperty double quality\nproperty list uchar int ring\n");
  text.insert(text.find("end_header"), "property uchar flags\nelement camera 1\nproperty int a\n");
  for (const char* row : {"1 0.25\n", "1 1\n", "0 1\n", "0 0\n"}) {
    const size_t end = text.find(row, text.find("end_header")) + std::strlen(row) - 1;
    text.insert(end, concat(" ", row[0] - '0' + 200, " 0.1 2 7 8"));
  }
  for (const char* row : {"3 0 1 2\n", "3 0 2 3\n"}) text.insert(text.find(row) + 7, " 1");
  text += "5\nand more\n";
  const Asset asset = parsed_ply(text);
  const std::vector<OwnColumn>& own = asset.meshes.at(0).own;
  ASSERT_EQ(own.size(), 2u);
  EXPECT_EQ(own[0].name, "label");
  EXPECT_EQ(own[0].type, PlyType::kUint8);
  EXPECT_EQ(own[0].value, (std::vector<double>{200, 201, 201, 200}));
  EXPECT_EQ(own[1].name, "quality");
  EXPECT_EQ(own[1].value, (std::vector<double>(4, 0.1)));
  EXPECT_EQ(test::finding_of(asset, "header-lines"), 1);
  EXPECT_EQ(test::finding_of(asset, "left-out-properties"), 3);  // ring, flags, camera
  EXPECT_EQ(test::finding_of(asset, "extra-bytes"), 7);
  for (const Finding& finding : asset.findings)
    if (finding.what == "left-out-properties")
      expect_says(finding.text, "vertex.ring, face.flags, camera");
}

TEST(PlyReader, BinaryFilesThatEndEarlySayWhere) {
  const std::string whole = binary_quad(std::endian::little, "binary_little_endian");
  const size_t body = whole.find("end_header\n") + 11;
  const std::pair<size_t, const char*> cases[] = {
      {body + 2 * 27 + 5, "the header claims 4 times vertex but only 59 bytes follow"},
      {body + 4 * 27 + 3, "the file ends within extra 1 of 2 (counted from 0)"},
      {whole.size() - 1, "the file ends within face 0 of 1 (counted from 0)"}};
  for (const auto& [size, message] : cases)
    expect_says(error_of([&, n = size] { parsed_ply(whole.substr(0, n)); }), message);
}

TEST(PlyReader, NoCutAndNoByteOfCornersBreaksIt) {
  const std::string text = CornerFile(2, "comment TextureFile a.png\n", true).text;
  test::expect_no_cut_is_read(parse_ply, text, 3);  // the last number may lose its digits
  test::expect_any_byte_is_read_or_refused(parse_ply, text);
}

TEST(PlyReader, RefusesHeadersThatCannotBe) {
  const std::string vertex = "property float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_index\nend_header\n";
  const auto header = [&](const std::string& count, const std::string& rest) {
    return "ply\nformat ascii 1.0\nelement vertex " + count + "\n" + vertex + face + rest;
  };
  // lines of the header, counts, rows of text, and elements without what a mesh needs
  const std::pair<std::string, std::string> cases[] = {
      {"", "file.ply:0: the header has no end"},
      {"ply\n", "file.ply:1: the header has no end"},
      {"plx\nformat", "begins with \"ply\""},
      {"ply\nend_header\n", "no format line"},
      {"ply\nformat utf-7 1.0\n", "file.ply:2: unknown format \"utf-7\""},
      {"ply\nformat ascii 1.0\nproperty float x\n", "a property before the first element"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n", "unknown type \"quad\""},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float\n", "a property without a name"},
      {"ply\n" + std::string(1 << 20, 'x'), "the header has no end"},
      {"ply\n" + std::string(1 << 20, '\n'), "the header has no end"},
      {header("-1", "0 0 0"), "the element vertex has no valid count"},
      {header("1e3", "0 0 0"), "the element vertex has no valid count"},
      {header("99999999999999999999", "0 0 0"), "the element vertex has no valid count"},
      {header("2000000000", "0 0 0"), "claims 2000000000 times vertex but only 5 bytes follow"},
      {header("1", "0 0 0"), "file.ply:10: the file ends before face 0 of 1 (counted from 0)"},
      {header("1", "0 0 0\n"), "file.ply:10: the file ends before face 0 of 1"},
      {header("2", "0 0 0\n\n0 0\n3 0 0 0"),
       "file.ply:12: vertex 1 of 2 (counted from 0) has fewer"},
      {header("1", "0 0 0 7\n3 0 0 0"), "file.ply:10: vertex 0 of 1 (counted from 0) has more"},
      {header("1", "0 0 0 3 0 0 0"), "file.ply:10: vertex 0 of 1 (counted from 0) has more"},
      {header("1", "0 0 0\n3 0 0 0 0"), "file.ply:11: face 0 of 1 (counted from 0) has more"},
      {header("2", "0 0 0\n3 0 0 0"), "file.ply:11: vertex 1 of 2 (counted from 0) has more"},
      {header("1", "0 0 0\n3 0 0"), "claims 3 values of vertex_index but only 4 bytes"},
      {header("1", "0 0 0\n3 0 0     "), "claims 3 values of vertex_index but only 4 bytes"},
      {header("1", "0 0 0\n-3 0 0 0"), "has a list of vertex_index of the length -3"},
      {header("1", "0 0 0\n2.5 0 0 0"), "has a list of vertex_index of the length 2.5"},
      {header("1", "0 0 0\n3 0 0 1"), "face 0 has the vertex index 1, the file has 1 vertices"},
      {header("1", "0 0 0\n3 0 0 -1"), "face 0 has the vertex index -1"},
      {header("1", "0 0 zero\n3 0 0 0"), "file.ply:10: a number is expected, not \"zero\""},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n" + face + "0\n3 0 0 0",
       "its vertices have no x, y, z"},
      {"ply\nformat ascii 1.0\nelement face 1\nproperty int a\nend_header\n0",
       "its faces have no list vertex_indices"},
  };
  for (const auto& [text, message] : cases)
    expect_says(error_of([&, &t = text] { parsed_ply(t); }), message);
}

TEST(PlyReader, RefusesFacesOfTooManyCorners) {
  std::string corners;
  for (int k = 0; k <= 1 << 16; ++k) corners += " 0";
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list int int vertex_index\nend_header\n"
      "0 0 0\n65537" +
      corners;
  expect_says(error_of([&] { parsed_ply(text); }), "face 0 has 65537 corners, at most 65536");
}

TEST(PlyReader, PassesAByteOrderMark) {
  EXPECT_EQ(parsed_ply("\xef\xbb\xbf" + std::string(kPlyText)).meshes[0].position,
            parsed_ply(kPlyText).meshes[0].position);
}

TEST(PlyReader, WrongEncodingsAreRefused) {
  const auto check = [](std::string bytes) {
    Asset asset = parsed_ply(bytes);
    check_asset(asset);
  };
  EXPECT_FALSE(
      error_of([&] { check(binary_quad(std::endian::big, "binary_little_endian")); }).empty());
  EXPECT_FALSE(
      error_of([&] { check(binary_quad(std::endian::little, "binary_big_endian")); }).empty());
  EXPECT_FALSE(error_of([&] { check(binary_quad(std::endian::little, "ascii")); }).empty());
  std::string text = kPlyText;
  text.replace(text.find("ascii"), 5, "binary_little_endian");
  EXPECT_FALSE(error_of([&] { check(text); }).empty());
}

TEST(PlyReader, AnyTruncationOfABinaryFileIsRefused) {
  const std::string bytes = binary_quad(std::endian::little, "binary_little_endian");
  EXPECT_NO_THROW(parsed_ply(bytes));
  for (size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(error_of([&] { parsed_ply(bytes.substr(0, n)); }).empty()) << n;
}

TEST(PlyReader, AnyTruncationOfATextIsReadOrRefused) {
  const std::string text = kPlyText;
  for (size_t n = 0; n < text.size(); ++n) {
    try {
      EXPECT_LE(parsed_ply(text.substr(0, n)).meshes[0].groups[0].corner.size(), 6u);
      EXPECT_GE(n + 2, text.size()) << "values are missing";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
    }
  }
}

TEST(PlyReader, AnyChangedByteIsReadOrRefused) {
  const std::string bytes = binary_quad(std::endian::little, "binary_little_endian");
  for (size_t n = 0; n < bytes.size(); ++n)
    for (const unsigned char value : {0, 1, 0x7f, 0x80, 0xff}) {
      std::string changed = bytes;
      changed[n] = char(value);
      try {
        Asset asset = parsed_ply(changed);
        check_asset(asset);
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
      }
    }
}

TEST(PlyReader, ReadsRealFilesWithTheirCounts) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) return;
  const Surface duck = pose_surface(read_ply(folder + "formats/bob_small.ply"));
  EXPECT_EQ(duck.triangles.rows(), 500);
  EXPECT_EQ(duck.vertices.rows(), 250);
  EXPECT_NEAR(weld(duck).volume, 0.679, 5e-4);
  const Asset corgi = read_ply(folder + "generators/point_e_corgi.ply");
  EXPECT_EQ(corgi.meshes[0].position.size(), 1585u);
  EXPECT_EQ(corgi.meshes[0].colour.size(), 1585u);
  EXPECT_TRUE(weld(pose_surface(corgi)).closed());
  EXPECT_EQ(weld(pose_surface(read_ply(folder + "broken/lego.ply"))).border_edges, 224);
  const PointCloud cloud = *read_ply(folder + "points/spot_points_normals.ply").points;
  EXPECT_EQ(cloud.position.size(), 20000u);
  EXPECT_EQ(cloud.normal.size(), 20000u);
  EXPECT_EQ(cloud.colour.size(), 20000u);
}

}  // namespace
}  // namespace elastogen
