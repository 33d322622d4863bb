// SPDX-License-Identifier: Apache-2.0
#include "io/ply_mesh.hpp"

#include "io/asset_check.hpp"
#include "io/obj_reader.hpp"
#include "io/output_findings.hpp"
#include "io/ply_reader.hpp"
#include "io/safe_file.hpp"
#include "tests/io/test_files.hpp"

#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

using test::expect_says;

/// Writes frames of displacements and reads the last of them.
class Sequence {
 public:
  explicit Sequence(const Asset& asset) : asset_(asset), surface_(pose_surface(asset)) {}

  Asset read_back(const Array<double>& displacement) {
    const auto writer = AnimationWriter::create(folder.path("out.ply"), asset_, surface_);
    writer->frame({.displacement = displacement});
    writer->finish();
    text = read_file(folder.path("out_00000.ply"));
    Asset back = read_ply(folder.path("out_00000.ply"));
    check_asset(back);
    return back;
  }

  Asset at_rest() { return read_back(Array<double>(surface_.vertices.rows(), 3)); }

  const Surface& surface() const { return surface_; }
  test::TempFolder folder;
  std::string text;

 private:
  const Asset& asset_;
  Surface surface_;
};

/// uv, colour and material's name of the corners of all triangles, as sorted texts.
std::vector<std::string> corners_of(const Asset& asset) {
  std::vector<std::string> corners;
  const Mesh& mesh = asset.meshes.at(0);
  for (const TriangleGroup& group : mesh.groups)
    for (const int32_t corner : group.corner) {
      const auto v = size_t(corner);
      std::string text = concat(mesh.position_of[v], ' ');
      if (!mesh.uv.empty() && group.has_uv) text += concat(mesh.uv[v][0], ' ', mesh.uv[v][1], ' ');
      if (!mesh.colour.empty())
        for (const float c : mesh.colour[v]) text += concat(std::lround(1000 * c), ' ');
      if (group.material >= 0) text += asset.materials[size_t(group.material)].name;
      corners.push_back(text);
    }
  std::ranges::sort(corners);
  return corners;
}

constexpr const char* kVertices =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0.25 0.75\n";

TEST(PlyMesh, SeamsBecomeCoordinatesOfCorners) {
  Asset asset = parse_obj(std::string(kVertices) + "f 1/1 2/2 3/3\nf 1/4 3/1 4/2\n", "file.obj");
  check_asset(asset);
  Sequence sequence(asset);
  const Asset back = sequence.at_rest();
  expect_says(sequence.text, "property list uchar float texcoord");
  EXPECT_EQ(back.meshes[0].position, asset.meshes[0].position);
  EXPECT_EQ(corners_of(back), corners_of(asset));

  // without a seam they belong to vertices
  asset = parse_obj(std::string(kVertices) + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n", "file.obj");
  check_asset(asset);
  Sequence plain(asset);
  const Asset same = plain.at_rest();
  expect_says(plain.text, "property float s\nproperty float t\n");
  EXPECT_EQ(plain.text.find("texcoord"), std::string::npos);
  EXPECT_EQ(corners_of(same), corners_of(asset));
}

TEST(PlyMesh, TexturesKeepTheirNamesAndFaces) {
  const test::TempFolder folder;
  folder.write("a.mtl", "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\nnewmtl c\nKd 1 0 0\n");
  folder.write("a.png", "png");
  folder.write("b.png", "png");
  const std::string head = std::string("mtllib a.mtl\n") + kVertices;
  // one texture, two, one on a part of the faces, one without uv on the second face
  const std::pair<const char*, std::vector<std::string>> cases[] = {
      {"usemtl a\nf 1/1 2/2 3/3\n", {"a.png"}},
      {"usemtl b\nf 1/1 2/2 3/3\nusemtl a\nf 1/4 3/1 4/2\n", {"a.png", "b.png"}},
      {"usemtl b\nf 1/1 2/2 3/3\nusemtl c\nf 1/4 3/1 4/2\n", {"", "b.png"}},
      {"usemtl b\nf 1/1 2/2 3/3\nusemtl a\nf 1 3 4\n", {"", "b.png"}}};  // the second lacks uv
  // written as PLY and read again
  for (const auto& [faces, names] : cases) {
    Asset asset = read_obj(folder.write("a.obj", head + faces));
    check_asset(asset);
    const Surface surface = pose_surface(asset);
    const auto writer = AnimationWriter::create(folder.path("out.ply"), asset, surface);
    writer->frame({.displacement = Array<double>(surface.vertices.rows(), 3)});
    writer->finish();
    const Asset back = read_ply(folder.path("out_00000.ply"));
    std::vector<std::string> found;
    for (const TriangleGroup& group : back.meshes.at(0).groups)
      found.push_back(group.material < 0 ? "" : back.materials[size_t(group.material)].name);
    std::ranges::sort(found);
    EXPECT_EQ(found, names) << faces;
  }
}

TEST(PlyMesh, OwnColumnsComeBackAsTheyWere) {
  // the extremes of every type
  const char* types[] = {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};
  const char* values[] = {"-128",        "255",        "-32768", "65535",
                          "-2147483648", "4294967295", "0.5",    "0.1"};
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\n";
  for (const char* type : types) text += concat("property ", type, " own_", type, '\n');
  text += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (const char* x : {"0 0 0", "1 0 0", "0 1 0"}) {
    text += x;
    for (const char* value : values) text += concat(' ', x[0] == '1' ? "1" : value);
    text += '\n';
  }
  // they come back with name, type and value
  Asset asset = parse_ply(text + "3 0 1 2\n", "file.ply");
  check_asset(asset);
  Sequence sequence(asset);
  const std::vector<OwnColumn> own = sequence.at_rest().meshes.at(0).own;
  ASSERT_EQ(own.size(), 8u);
  for (size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(own[k].name, concat("own_", types[k]));
    EXPECT_EQ(own[k].type, PlyType(k));
    EXPECT_EQ(own[k].value, (std::vector<double>{std::stod(values[k]), 1, std::stod(values[k])}));
  }
  // other formats cannot hold them
  const auto findings = output_findings(asset, sequence.surface(), {"a.ply", "b.glb", "c.pc2"});
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].what, "own-columns");
  EXPECT_EQ(findings[0].count, 8);
  expect_says(findings[0].text, "have no place in b.glb, c.pc2: own_char, own_uchar");
  EXPECT_TRUE(output_findings(asset, sequence.surface(), {"a.ply"}).empty());
}

TEST(PlyMesh, ColoursOfFacesStayColoursOfFaces) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::string colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string face = "element face 2\nproperty list uchar int vertex_indices\n";
  const std::string of_faces = head + face + colours +
                               "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 255 0 9\n"
                               "3 0 2 3 1 2 3\n";
  const std::string of_vertices = head + colours + face +
                                  "end_header\n0 0 0 255 0 9\n1 0 0 1 2 3\n1 1 0 4 5 6\n"
                                  "0 1 0 7 8 9\n3 0 1 2\n3 0 2 3\n";
  for (const std::string& text : {of_faces, of_vertices}) {
    Asset asset = parse_ply(text, "file.ply");
    check_asset(asset);
    Sequence sequence(asset);
    const Asset back = sequence.at_rest();
    EXPECT_EQ(corners_of(back), corners_of(asset));
    EXPECT_EQ(sequence.text.find("red") > sequence.text.find("element face"), text == of_faces);
  }
}

TEST(PlyMesh, NormalsTurnWithTheBody) {
  // the node mirrors x and stretches y: a covector (n_x, n_y, n_z) becomes (-n_x, n_y / 2, n_z)
  const float s = std::sqrt(0.5f);
  Asset asset;
  asset.path = "file.obj";
  asset.format = "obj";
  Mesh& mesh = asset.meshes.emplace_back();
  mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.position_of = {0, 1, 2};
  mesh.groups.push_back({-1, {0, 1, 2}, -1});
  mesh.normal = {{0, 0, 1}, {s, 0, s}, {0, s, s}};
  Matrix4 matrix = kIdentity4;
  matrix[0] = -1, matrix[5] = 2;
  asset.nodes.push_back({"", -1, matrix, 0});
  Sequence sequence(asset);
  const double r = std::sqrt(0.8);  // (0, 1/2, 1) made of length one is (0, r / 2, r)
  const Vec3 rest[3] = {{0, 0, 1}, {-s, 0, s}, {0, r / 2, r}};
  for (const double angle : {0., 0.5, std::numbers::pi / 2, 3.}) {
    // about y
    Array<double> u(3, 3);
    const double c = std::cos(angle), d = std::sin(angle);
    for (int v = 0; v < 3; ++v) {
      const double x = sequence.surface().vertices(v, 0), z = sequence.surface().vertices(v, 2);
      u(v, 0) = c * x + d * z - x;
      u(v, 2) = -d * x + c * z - z;
    }
    const Asset back = sequence.read_back(u);
    for (size_t v = 0; v < 3; ++v) {
      const Vec3& n = rest[v];
      const Vec3 turned = {c * n[0] + d * n[2], n[1], -d * n[0] + c * n[2]};
      for (size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(back.meshes.at(0).normal.at(v)[k], turned[k], 1e-6) << angle << ' ' << v;
    }
  }
}

TEST(PlyMesh, SeveralNormalsOfAVertexAreLeftOutAndSaid) {
  Asset asset = parse_obj(std::string(kVertices) +
                              "vn 0 0 1\nvn 0 -1 0\nf 1//1 2//1 3//1\n"
                              "f 1//2 2//2 5//2\n",
                          "file.obj");
  check_asset(asset);
  Sequence sequence(asset);
  EXPECT_TRUE(sequence.at_rest().meshes.at(0).normal.empty());
  const auto findings = output_findings(asset, sequence.surface(), {"a.ply"});
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].what, "corner-normals");
  EXPECT_EQ(findings[0].count, 2);
  EXPECT_TRUE(output_findings(asset, sequence.surface(), {"a.glb", "a.pc2"}).empty());
}

/// A tetrahedron of longest edge one at a place.
Asset far_body(const Vec3& place) {
  Asset asset = parse_obj(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0.125\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4", "file.obj");
  for (Vec3& x : asset.meshes[0].position)
    for (size_t d = 0; d < 3; ++d) x[d] += place[d];
  check_asset(asset);
  return asset;
}

TEST(PlyMesh, BodiesFarAwayAreWrittenInDoubles) {
  for (const Vec3& place : {Vec3{3e7, -2e7, 1e7}, Vec3{0, 500, 0}, Vec3{0, 0, 0}, Vec3{80, 0, 0}}) {
    const Asset asset = far_body(place);
    // the step of float32 at 3e7 is 2, at 500 it is 2^-15 = 3.05e-5, at 80 2^-17 = 7.6e-6
    const bool far = place[0] > 100 || place[1] > 100;
    Sequence sequence(asset);
    const Asset back = sequence.at_rest();
    EXPECT_EQ(sequence.text.find("property double x") != std::string::npos, far);
    EXPECT_EQ(back.meshes.at(0).position, asset.meshes[0].position);
    const auto findings = output_findings(asset, sequence.surface(), {"a.pc2", "a.glb", "a.ply"});
    ASSERT_EQ(findings.size(), far ? 1u : 0u);
    if (!far) continue;
    EXPECT_EQ(findings[0].what, "rounded-positions");
    expect_says(findings[0].text, place[0] > 100 ? "of a.pc2 go by steps of 2 there"
                                                 : "go by steps of 3.05176e-05 there");
  }
}

}  // namespace
}  // namespace elastogen
