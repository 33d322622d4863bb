// SPDX-License-Identifier: Apache-2.0
#include "io/ply_reader.hpp"

#include "tests/io/cloud_files.hpp"

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

Asset parsed_ply(std::string_view bytes) {
  return parse_ply(bytes, "file.ply");
}

/// Bytes of a value in an order.
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
                    "property list uchar float texcoord\nproperty list uint int vertex_indices\n"
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
      "3 2 1 0\n0 0 0 1 0 0 0 1 0");
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

TEST(PlyReader, RefusesHeadersThatCannotBe) {
  const std::string vertex = "property float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_index\nend_header\n";
  const auto header = [&](const std::string& count, const std::string& rest) {
    return "ply\nformat ascii 1.0\nelement vertex " + count + "\n" + vertex + face + rest;
  };
  const std::pair<std::string, std::string> cases[] = {
      {"", "file.ply:0: the header has no end"},
      {"ply\n", "file.ply:1: the header has no end"},
      {"plx\nformat", "begins with \"ply\""},
      {"ply\nend_header\n", "no format line"},
      {"ply\nformat utf-7 1.0\n", "file.ply:2: unknown format \"utf-7\""},
      {"ply\nformat ascii 1.0\nproperty float x\n", "a property before the first element"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n", "unknown type \"quad\""},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float\n", "a property without a name"},
      {"ply\nnonsense\n", "file.ply:2: unknown header line \"nonsense\""},
      {"ply\n" + std::string(1 << 20, 'x'), "the header has no end"},
      {"ply\n" + std::string(1 << 20, '\n'), "the header has no end"},
      {header("-1", "0 0 0"), "the element vertex has no valid count"},
      {header("1e3", "0 0 0"), "the element vertex has no valid count"},
      {header("99999999999999999999", "0 0 0"), "the element vertex has no valid count"},
      {header("2000000000", "0 0 0"), "claims 2000000000 times vertex but only 5 bytes follow"},
      {header("1", "0 0 0"), "the file ends before its values do"},
      {header("1", "0 0 0 3 0 0"), "3 values of vertex_index are claimed but only 4 bytes"},
      {header("1", "0 0 0 -3 0 0 0"), "a list of vertex_index has the length -3"},
      {header("1", "0 0 0 2.5 0 0 0"), "a list of vertex_index has the length 2.5"},
      {header("1", "0 0 0 3 0 0 1"), "face 0 has the vertex index 1, the file has 1 vertices"},
      {header("1", "0 0 0 3 0 0 -1"), "face 0 has the vertex index -1"},
      {header("1", "0 0 zero 3 0 0 0"), "a number is expected, not \"zero\""},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n" + face + "0 3 0 0 0",
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
