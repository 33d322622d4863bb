// SPDX-License-Identifier: Apache-2.0
#include "io/obj_reader.hpp"

#include "io/asset_check.hpp"
#include "io/polygon.hpp"
#include "tests/io/test_files.hpp"

#include <clocale>
#include <cmath>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

Asset parsed_obj(std::string_view text) {
  return parse_obj(text, "file.obj");
}

/// Triangles in positions, all groups.
std::vector<std::array<int32_t, 3>> triangles_of(const Mesh& mesh) {
  std::vector<std::array<int32_t, 3>> out;
  for (const TriangleGroup& group : mesh.groups)
    for (size_t k = 0; k < group.corner.size(); k += 3) {
      std::array<int32_t, 3> t;
      for (size_t c = 0; c < 3; ++c) t[c] = mesh.position_of[size_t(group.corner[k + c])];
      out.push_back(t);
    }
  return out;
}

const Finding* finding(const Asset& asset, const std::string& what) {
  for (const Finding& f : asset.findings)
    if (f.what == what) return &f;
  return nullptr;
}

constexpr const char* kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

TEST(ObjReader, KeepsTheVertexOrderOfTheFile) {
  const Asset asset = parsed_obj(
      "v 5 6 7\nv 1e-3 -2.5E+2 +3\nv 9 9 9\no first\nf 3 2 1\nv 4 5 6 1.0\nf 4 1 2\n"
      "o empty\n");
  ASSERT_EQ(asset.meshes.size(), 1u);
  const Mesh& mesh = asset.meshes[0];
  EXPECT_EQ(mesh.name, "first");
  EXPECT_EQ(mesh.position, (std::vector<Vec3>{{5, 6, 7}, {0.001, -250, 3}, {9, 9, 9}, {4, 5, 6}}));
  EXPECT_EQ(mesh.position_of, (std::vector<int32_t>{0, 1, 2, 3}));
  EXPECT_EQ(triangles_of(mesh), (std::vector<std::array<int32_t, 3>>{{2, 1, 0}, {3, 0, 1}}));
  EXPECT_TRUE(mesh.uv.empty() && mesh.normal.empty() && mesh.colour.empty());
  EXPECT_TRUE(mesh.file_position.empty());
  ASSERT_EQ(asset.nodes.size(), 1u);
  EXPECT_EQ(asset.nodes[0].mesh, 0);
}

/// Name, parent and number of triangles of each node.
std::string tree_of(const Asset& asset) {
  std::string text;
  for (const AssetNode& node : asset.nodes) {
    text += concat(node.name, '<', node.parent < 0 ? "" : asset.nodes[size_t(node.parent)].name);
    if (node.mesh >= 0) text += concat(':', triangles_of(asset.meshes[size_t(node.mesh)]).size());
    text += ' ';
  }
  return text;
}

TEST(ObjReader, ObjectsAndGroupsAreNodes) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", f = "f 1 2 3\n";
  const std::pair<std::string, std::string> cases[] = {
      {f, "file<:1 "},
      {"o Body\n" + f, "Body<:1 "},
      {f + "o Body\n" + f, "file<:1 Body<:1 "},
      {"o Body\n" + f + "o Hat\n" + f + f + "o Body\n" + f, "Body<:2 Hat<:2 "},
      {"g left arm\n" + f + "g\n" + f + "g left arm\n" + f, "left arm<:2 file<:1 "},
      {"o Body\ng A\n" + f + "g B\n" + f + "o Hat\ng A\n" + f,
       "Body< A<Body:1 B<Body:1 Hat< A<Hat:1 "},
      {"o Body\n" + f + "g A\n" + f + "g\n" + f, "Body<:2 A<Body:1 "},
      {"g default\ng A\nf 1 2\ng B\n" + f, "B<:1 "},
      {"g A\n" + f + "o Body\n" + f, "A<:1 Body<:1 "},
      {"o A\ng A\n" + f, "A< A<A:1 "},
  };
  for (const auto& [text, tree] : cases) EXPECT_EQ(tree_of(parsed_obj(v + text)), tree) << text;
  EXPECT_EQ(parsed_obj("o Cloud\n" + v).nodes.at(0).name, "Cloud");
}

TEST(ObjReader, ObjectsHoldWhatTheyUseAndTheFilesNumbersOfIt) {
  // 2 and 3 belong to both, 5 to none
  Asset asset = parsed_obj(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nv 9 9 9\nvt 0 0\nvt 1 0\nvt 0 1\n"
      "o B\nf 4/1 3/2 2/3\no A\nf 1 2 3\n");
  ASSERT_EQ(asset.meshes.size(), 2u);
  EXPECT_EQ(asset.meshes[0].file_position, (std::vector<int32_t>{1, 2, 3, 4}));
  EXPECT_EQ(asset.meshes[1].file_position, (std::vector<int32_t>{0, 1, 2}));
  EXPECT_EQ(asset.meshes[0].position[2], (Vec3{1, 1, 0.5}));
  EXPECT_EQ(triangles_of(asset.meshes[0]), (std::vector<std::array<int32_t, 3>>{{2, 1, 0}}));
  EXPECT_EQ(asset.meshes[0].uv.at(2), (std::array<float, 2>{0, 1}));
  EXPECT_TRUE(asset.meshes[1].uv.empty());
  EXPECT_EQ(repeated_positions(asset), 2);
  check_asset(asset);
  EXPECT_EQ(finding(asset, "duplicate-vertices"), nullptr);  // the file has each once
  EXPECT_EQ(finding(asset, "unreferenced")->count, 1);
  // the body is one piece as before
  EXPECT_EQ(weld(pose_surface(asset)).vertices.rows(), 4);
  EXPECT_EQ(finding(asset, "pieces"), nullptr);
}

TEST(ObjReader, ReadsEveryFormOfACorner) {
  const char* attributes = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.25\nvt 0 0\nvn 0 0 2\n";
  for (const char* face :
       {"f 1 2 3", "f 1/1 2/1 3/2", "f 1//1 2//1 3//1", "f 1/1/1 2/1/1 3/2/1", "f -3 -2 -1",
        "f -3/-2/-1 -2/-2/-1 -1/-1/-1", "f 1/ 2/ 3/", "f\t1  2 3   # a comment"}) {
    const Asset asset = parsed_obj(std::string(attributes) + face + "\n");
    EXPECT_EQ(triangles_of(asset.meshes[0]), (std::vector<std::array<int32_t, 3>>{{0, 1, 2}}))
        << face;
  }
  const Mesh mesh = parsed_obj(std::string(attributes) + "f 1/1/1 2/1/1 3/2/1").meshes[0];
  EXPECT_EQ(mesh.uv[0], (std::array<float, 2>{0.25f, 0.75f}));  // v runs down as in glTF
  EXPECT_EQ(mesh.normal[0], (std::array<float, 3>{0, 0, 2}));   // the check makes it one long
}

TEST(ObjReader, SplitsSeamsBehindTheFilesPositions) {
  const Mesh mesh = parsed_obj(
                        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 1\n"
                        "f 1/1 2/1 3/1\nf 2/2 4/2 3/1\nf 2/2 3/1 4/2\n")
                        .meshes[0];
  EXPECT_EQ(mesh.position.size(), 4u);
  EXPECT_EQ(mesh.position_of, (std::vector<int32_t>{0, 1, 2, 3, 1}));
  EXPECT_EQ(mesh.groups[0].corner, (std::vector<int32_t>{0, 1, 2, 4, 3, 2, 4, 2, 3}));
  EXPECT_EQ(mesh.uv[1], (std::array<float, 2>{0, 1}));
  EXPECT_EQ(mesh.uv[4], (std::array<float, 2>{1, 0}));
}

TEST(ObjReader, ConcavePolygonsKeepTheirArea) {
  // an L of area 3, its notch at (1, 1): a fan from any corner but the notch's would overlap it
  const std::vector<Vec3> shape = {{0, 0, 5}, {2, 0, 5}, {2, 1, 5},
                                   {1, 1, 5}, {1, 2, 5}, {0, 2, 5}};
  for (size_t first = 0; first < 6; ++first) {
    std::vector<Vec3> polygon;
    for (size_t k = 0; k < 6; ++k) polygon.push_back(shape[(first + k) % 6]);
    const std::vector<int> t = triangulate(polygon);
    ASSERT_EQ(t.size(), 12u);
    for (size_t k = 0; k < t.size(); k += 3) {
      const Vec3 &a = polygon[size_t(t[k])], &b = polygon[size_t(t[k + 1])],
                 &c = polygon[size_t(t[k + 2])];
      const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
      EXPECT_GE(area, 0) << "a triangle turned over, first corner " << first;
    }
    double sum = 0;
    for (size_t k = 0; k < t.size(); k += 3) {
      const Vec3 &a = polygon[size_t(t[k])], &b = polygon[size_t(t[k + 1])],
                 &c = polygon[size_t(t[k + 2])];
      sum += 0.5 * std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    }
    EXPECT_DOUBLE_EQ(sum, 3);
  }
}

TEST(ObjReader, PolygonsWithoutAreaStillGiveTriangles) {
  const std::vector<Vec3> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(triangulate(line).size(), 6u);
  const std::vector<Vec3> bow = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(triangulate(bow).size(), 6u);
  EXPECT_TRUE(triangulate({}).empty());
  EXPECT_EQ(triangulate(std::vector<Vec3>(5000)).size(), 3u * 4998);
}

TEST(ObjReader, QuadsContinuedLinesAndCrlfGiveAClosedCube) {
  std::string text = kCube;
  text.replace(text.find("f 4 3 2 1"), 9, "f 4 3 \\\n 2 1");
  std::string crlf = "\xef\xbb\xbf";
  for (const char c : text) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  for (const std::string& t : {text, crlf}) {
    const WeldedMesh w = weld(pose_surface(parsed_obj(t)));
    EXPECT_TRUE(w.closed() && w.balanced());
    EXPECT_EQ(w.triangles.rows(), 12);
    EXPECT_DOUBLE_EQ(w.volume, 1);
  }
}

TEST(ObjReader, NumbersDoNotDependOnTheLocale) {
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"})
    if (std::setlocale(LC_ALL, name)) break;
  const Asset asset = parsed_obj("v 0.5 0 0\nv 1.25 0 0\nv 0 1.5 0\nf 1 2 3");
  std::setlocale(LC_ALL, "C");
  EXPECT_EQ(asset.meshes[0].position[1], (Vec3{1.25, 0, 0}));
}

TEST(ObjReader, ColoursBehindPositionsAreSrgb) {
  const Mesh mesh = parsed_obj("v 0 0 0\nv 1 0 0 1 0 0.5\nv 0 1 0 0 0 0\nf 1 2 3").meshes[0];
  ASSERT_EQ(mesh.colour.size(), 3u);
  EXPECT_EQ(mesh.colour[0], (std::array<float, 4>{1, 1, 1, 1}));
  EXPECT_FLOAT_EQ(mesh.colour[1][0], 1);
  EXPECT_NEAR(mesh.colour[1][2], 0.2140411, 1e-6);  // sRGB 0.5 in linear light
}

TEST(ObjReader, GroupsFollowMaterialsAndMtlFillsThem) {
  const test::TempFolder folder;
  folder.write("größe 色.mtl",
               "newmtl rot 赤\r\nKd 0.5 0.25 0\r\nd 0.5\r\nmap_Kd -s 1 1 1 -o 0 skin tex.png\r\n"
               "newmtl other\nKd 1 1 1\nnewmtl plain\nKd x y z\nTr 0.25\nmap_Kd ../gone.png\n");
  folder.write("skin tex.png", "png");
  const Asset asset = read_obj(folder.write(
      "a.obj",
      "mtllib größe 色.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl rot 赤\nf 1 2 3\n"
      "usemtl plain\nf 3 2 1\nusemtl rot 赤\nf 2 3 1\n"));
  ASSERT_EQ(asset.materials.size(), 2u);
  EXPECT_EQ(asset.materials[0].name, "rot 赤");
  EXPECT_EQ(asset.materials[0].base_colour, (std::array<float, 4>{0.5f, 0.25f, 0, 0.5f}));
  EXPECT_EQ(std::filesystem::path(asset.materials[0].texture).filename(), "skin tex.png");
  EXPECT_EQ(asset.materials[1].base_colour, (std::array<float, 4>{0.8f, 0.8f, 0.8f, 0.75f}));
  const std::vector<TriangleGroup>& groups = asset.meshes[0].groups;
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[0].material, -1);
  EXPECT_EQ(groups[1].material, 0);
  EXPECT_EQ(groups[1].corner.size(), 6u);
  EXPECT_EQ(groups[2].material, 1);
  EXPECT_NE(finding(asset, "missing-texture"), nullptr);
  EXPECT_EQ(finding(asset, "missing-material-file"), nullptr);
}

TEST(ObjReader, AMissingMaterialFileIsAFinding) {
  for (const char* name : {"none.mtl", "/etc/passwd", "../../etc/passwd", "a.mtl b.mtl"}) {
    const Asset asset = parsed_obj(std::string("mtllib ") + name +
                                   "\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3");
    EXPECT_NE(finding(asset, "missing-material-file"), nullptr) << name;
    EXPECT_EQ(asset.materials.at(0).name, "m");
  }
}

TEST(ObjReader, NormalsOfSomeCornersOnlyAreNotUsed) {
  const Asset asset = parsed_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3");
  EXPECT_TRUE(asset.meshes[0].normal.empty());
  EXPECT_NE(finding(asset, "missing-normals"), nullptr);
}

TEST(ObjReader, FacesWithAndWithoutCoordinatesAreGroupsOfTheirOwn) {
  const Mesh mesh = parsed_obj(
                        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nusemtl m\n"
                        "f 1/1 2/2 3/1\nf 3 2 1\nf 1/1 2 3/2\nf 2/1 3/2 1/1\n")
                        .meshes.at(0);
  ASSERT_EQ(mesh.groups.size(), 2u);
  EXPECT_TRUE(mesh.groups[0].has_uv);
  EXPECT_EQ(mesh.groups[0].corner.size(), 6u);
  EXPECT_FALSE(mesh.groups[1].has_uv);
  EXPECT_EQ(mesh.groups[1].material, 0);
}

TEST(ObjReader, RefusesWithFileAndLine) {
  const std::pair<std::string, std::string> cases[] = {
      // statements
      {"v 0 0 0\nv 1 0", "file.obj:2: 3 numbers are expected"},
      {"v 0 0 zero", "file.obj:1: a number is expected, not \"zero\""},
      {"v 0 0 0\nf 1 1 2", "file.obj:2: vertex index 2 is out of range, the file has 1"},
      {"v 0 0 0\nf 1 1 -2", "file.obj:2: vertex index -2 is out of range"},
      {"v 0 0 0\nf 0 1 1", "file.obj:2: vertex index 0 is out of range"},
      {"v 0 0 0\nf 1/1 1/1 1/1", "file.obj:2: texture index 1 is out of range"},
      {"v 0 0 0\nf 1//9 1//9 1//9", "file.obj:2: normal index 9 is out of range"},
      {"v 0 0 0\nf 4294967296 1 1", "file.obj:2: vertex index 4294967296 is out of range"},
      {"v 0 0 0\nf 1 1 4294967295", "file.obj:2: vertex index 4294967295 is out of range"},
      {"v 0 0 0\nf 1 1 a", "file.obj:2: a corner is expected, not \"a\""},
      {"v 0 0 0\nf 1/1/1/1 1 1", "file.obj:2: "},
      {"v 0 0 0\n\nf 1 \\\n1 \\\nx", "file.obj:3: a corner is expected"},
      {std::string("v 0 0 0\nf \0 1 1", 15), "file.obj:2: a zero byte"},
  };
  for (const auto& [text, message] : cases)
    expect_says(error_of([&] { parsed_obj(text); }), message);
  // limits of material files and of corners
  expect_says(error_of([&] { parsed_obj("mtllib " + std::string(4097, 'x')); }),
              ":1: the names of");
  std::string libraries;
  for (int k = 0; k <= 1000; ++k) libraries += concat("mtllib m", k, '\n');
  expect_says(error_of([&] { parsed_obj(libraries); }), ":1001: more than 1000 material files");
  std::string face = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
  for (int c = 0; c < (1 << 16); ++c) face += concat(' ', c % 3 + 1);
  EXPECT_NO_THROW(parsed_obj(face));
  expect_says(error_of([&] { parsed_obj(face + " 2"); }), ":4: a face has more than 65536 corners");
}

TEST(ObjReader, AnyTruncationIsReadOrRefused) {
  const std::string text = std::string("mtllib a.mtl\nusemtl m\nvt 0 0.5\nvn 0 1 0\n") + kCube +
                           "f 1/1/1 -2/1/1 \\\n 3/1/1 # end\n";
  const size_t whole = parsed_obj(text).meshes[0].position.size();
  for (size_t n = 0; n < text.size(); ++n) {
    try {
      Asset asset = parsed_obj(std::string_view(text).substr(0, n));
      EXPECT_LE(asset.meshes[0].position.size(), whole);
      check_asset(asset);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
    }
  }
}

TEST(ObjReader, AnyByteOfObjectsAndGroupsMayBeWrong) {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvn 0 0 1\no A\ng 1\nf 1/1/1 3/1/1 "
      "2/2/1\n"
      "g\nf 1 2 4\no B\ng 1\nf 1/1 4/2 3/2\no A\ng 1\nf 2 3 4\n";
  for (size_t n = 0; n < text.size(); ++n)
    for (const char value : {'\0', '\n', ' ', '/', '-', '9', 'g', 'o', 'x', '\xff'}) {
      std::string changed = text;
      changed[n] = value;
      try {
        Asset asset = parsed_obj(changed);
        check_asset(asset);
        // repeated positions are counted, and the file's numbers are a row without gaps
        const Surface surface = pose_surface(asset);
        std::vector<uint8_t> seen(size_t(surface.vertices.rows() - repeated_positions(asset)), 0);
        for (const Mesh& mesh : asset.meshes)
          for (const int32_t p : mesh.file_position) seen.at(size_t(p)) = 1;
        EXPECT_EQ(std::ranges::count(seen, 0), asset.meshes.size() > 1 ? 0 : int64_t(seen.size()))
            << changed;
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
      }
    }
}

TEST(ObjReader, ReadsRealFilesWithTheirCounts) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) return;
  struct Row {
    const char* name;
    int64_t triangles, welded, border;
    double volume, tolerance;
  };
  // quads that are not planar are cut where that turns no triangle over, not always at 0-2
  const Row rows[] = {{"closed/spot.obj", 5856, 2930, 0, 0.718, 1e-3},
                      {"closed/armadillo.obj", 29170, 14587, 0, 0.0683, 1e-3},
                      {"closed/spot_quads.obj", 372, 188, 0, 0.845, 3e-3},
                      {"closed/tree.obj", 256, 148, 32, 0, 0},
                      {"broken/quads_ngons_negative.obj", 40, 24, 0, 1 + 4 * std::sqrt(2.), 1e-6},
                      {"broken/Кот Ünïcode 名前 spot.obj", 5856, 2930, 0, 0.718, 1e-3},
                      {"generators/triposr_mesh.obj", 67139, 33596, 99, 0, 0}};
  for (const Row& row : rows) {
    const Asset asset = read_obj(folder + row.name);
    const Surface surface = pose_surface(asset);
    EXPECT_EQ(surface.triangles.rows(), row.triangles) << row.name;
    const WeldedMesh w = weld(surface, 1e-7);  // the tolerance of the table
    EXPECT_EQ(w.vertices.rows(), row.welded) << row.name;
    EXPECT_EQ(w.border_edges, row.border) << row.name;
    if (w.closed()) {
      EXPECT_NEAR(w.volume, row.volume, row.tolerance * row.volume) << row.name;
    }
  }
  const Asset cat = read_obj(folder + "broken/Кот Ünïcode 名前 spot.obj");
  EXPECT_EQ(cat.nodes.at(0).name, "Größe 牛");  // its groups are below
  EXPECT_EQ(cat.materials.at(0).name, "glänzend 青");
  EXPECT_FLOAT_EQ(cat.materials[0].base_colour[1], 0.7f);
}

}  // namespace
}  // namespace elastogen
