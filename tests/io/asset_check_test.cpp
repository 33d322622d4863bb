// SPDX-License-Identifier: Apache-2.0
#include "io/asset_check.hpp"

#include "io/obj_reader.hpp"
#include "tests/io/cube_asset.hpp"
#include "tests/io/test_files.hpp"

#include <cmath>
#include <limits>

namespace elastogen {
namespace {

using test::corners, test::cube, test::error_of, test::expect_says;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

int64_t count_of(const Asset& asset, const std::string& what) {
  for (const Finding& f : asset.findings)
    if (f.what == what) return f.count;
  return 0;
}

int64_t count_after_check(Asset asset, const std::string& what) {
  check_asset(asset);
  return count_of(asset, what);
}

TEST(AssetCheck, ACleanCubeHasNoFindings) {
  for (const double a : {1e-6, 1., 5e16}) {
    Asset asset = cube(a);
    check_asset(asset);
    EXPECT_TRUE(asset.findings.empty()) << asset.findings[0].what;
    const WeldedMesh w = weld(pose_surface(asset));
    EXPECT_TRUE(w.closed() && w.balanced());
    EXPECT_EQ(w.pieces, 1);
    EXPECT_NEAR(w.volume / (a * a * a), 1, 1e-14);
  }
}

TEST(AssetCheck, FarFromTheOriginNothingIsLost) {
  Asset asset = cube(1.7, {1e7, -2e7, 5e6});
  check_asset(asset);
  EXPECT_TRUE(asset.findings.empty());
  EXPECT_NEAR(weld(pose_surface(asset)).volume, 1.7 * 1.7 * 1.7, 1e-7);
}

TEST(AssetCheck, NamesTheFirstVertexThatIsNotFinite) {
  for (const double bad : {kNan, HUGE_VAL, -HUGE_VAL}) {
    Asset asset = cube();
    asset.meshes[0].position[5][1] = bad;
    asset.meshes[0].position[7][0] = bad;
    expect_says(error_of([&] { check_asset(asset); }), "cube: mesh \"box\": vertex 5 ");
  }
}

TEST(AssetCheck, RefusesIndicesOutOfRange) {
  for (const int32_t bad : {8, -1, std::numeric_limits<int32_t>::max()}) {
    Asset asset = cube();
    corners(asset)[4] = bad;
    expect_says(error_of([&] { check_asset(asset); }), "mesh \"box\": triangle 1 has the vertex");
    asset = cube();
    asset.meshes[0].position_of[3] = bad;
    expect_says(error_of([&] { check_asset(asset); }), "drawn vertex 3 has the position");
    asset = cube();
    asset.meshes[0].groups[0].material = bad == -1 ? -2 : bad;
    expect_says(error_of([&] { check_asset(asset); }), "there is no material");
  }
}

TEST(AssetCheck, RefusesWhatCannotBeSimulated) {
  Asset asset = cube();
  corners(asset).clear();
  expect_says(error_of([&] { check_asset(asset); }), "nothing to simulate");
  asset = cube();
  asset.nodes.clear();
  expect_says(error_of([&] { check_asset(asset); }), "nothing to simulate");
  asset = cube();
  corners(asset) = {0, 0, 1, 2, 3, 3};
  expect_says(error_of([&] { check_asset(asset); }), "no triangle has an area");
  asset = cube();
  for (Vec3& x : asset.meshes[0].position) x[1] = x[2] = 0;
  expect_says(error_of([&] { check_asset(asset); }), "no triangle has an area");
  asset = cube(0);
  expect_says(error_of([&] { check_asset(asset); }), "lie in one point");
  for (const double a : {1e-200, 1e200}) {
    asset = cube(a);
    expect_says(error_of([&] { check_asset(asset); }), "out of range");
  }
}

TEST(AssetCheck, RefusesAUnitThatTakesTheSizeOutOfRange) {
  for (const double unit : {5e-324, 1e-200, 1e200}) {
    Asset asset = cube();
    asset.unit = unit;
    expect_says(error_of([&] { check_asset(asset); }), "out of range");
  }
}

TEST(AssetCheck, NormalsAreMadeOfLengthOne) {
  const float third = float(1 / std::sqrt(3.));
  Asset asset = cube(2);
  std::vector<std::array<float, 3>>& normal = asset.meshes[0].normal;
  normal.assign(8, {0, 0.6f, 0.8f});
  normal[1] = {0, 3, 4};
  normal[2] = {0, 0, 1e-30f};
  normal[3] = {0, 0, -1.005f};  // not reported, but corrected
  // the mean by area at a cube's corner, however its squares are cut: 2 : 2 : 2 or 1 : 2 : ...
  normal[0] = {0, 0, 0};
  normal[6] = {0, -0.f, 0};
  Asset twice = asset;
  check_asset(asset);
  EXPECT_EQ(count_of(asset, "long-normals"), 2);
  EXPECT_EQ(count_of(asset, "zero-normals"), 2);
  EXPECT_NEAR(normal[1][1], 0.6f, 1e-7);
  EXPECT_NEAR(normal[1][2], 0.8f, 1e-7);
  EXPECT_EQ(normal[2], (std::array<float, 3>{0, 0, 1}));
  EXPECT_EQ(normal[3], (std::array<float, 3>{0, 0, -1}));
  EXPECT_EQ(normal[4], (std::array<float, 3>{0, 0.6f, 0.8f}));
  // corner 0 has two triangles of each of its squares
  for (size_t d = 0; d < 3; ++d) EXPECT_NEAR(normal[0][d], -third, 1e-6);
  for (const auto& n : normal) EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-6);

  // a vertex without faces looks along z; outputs keep a glTF's own numbers
  twice.meshes[0].position.push_back({9, 9, 9});
  twice.meshes[0].position_of.push_back(8);
  twice.meshes[0].normal.push_back({0, 0, 0});
  Asset gltf = twice;
  gltf.format = "glb";
  check_asset(twice);
  EXPECT_EQ(twice.meshes[0].normal[8], (std::array<float, 3>{0, 0, 1}));
  check_asset(gltf);
  EXPECT_EQ(gltf.meshes[0].normal[1], (std::array<float, 3>{0, 3, 4}));
}

TEST(AssetCheck, TexturesWithoutCoordinatesAreDroppedAndSaid) {
  Asset asset = cube();
  asset.materials.push_back({"skin", {1, 0.5f, 0.25f, 1}, "skin.png"});
  asset.materials.push_back({"plain", {1, 1, 1, 1}, ""});
  Mesh other = asset.meshes[0];
  other.name = "other";
  other.uv.assign(8, {0.5f, 0.5f});
  other.groups.push_back(other.groups[0]);
  for (TriangleGroup& group : other.groups) group.material = 0;
  other.groups[1].has_uv = false;
  asset.meshes[0].groups[0].material = 0;
  asset.meshes.push_back(other);
  asset.nodes.push_back({"other", -1, kIdentity4, 1});
  check_asset(asset);
  EXPECT_EQ(count_of(asset, "missing-uvs"), 24);
  for (const Finding& f : asset.findings)
    if (f.what == "missing-uvs") expect_says(f.text, "the first in the mesh \"box\"");
  ASSERT_EQ(asset.materials.size(), 3u);
  EXPECT_EQ(asset.meshes[0].groups[0].material, 2);
  EXPECT_EQ(asset.meshes[1].groups[0].material, 0);
  EXPECT_EQ(asset.meshes[1].groups[1].material, 2);
  EXPECT_EQ(asset.materials[2].name, "skin");
  EXPECT_EQ(asset.materials[2].base_colour, (std::array<float, 4>{1, 0.5f, 0.25f, 1}));
  EXPECT_TRUE(asset.materials[2].texture.empty());
  EXPECT_EQ(asset.materials[0].texture, "skin.png");

  // a material that nothing else shows is not copied
  asset = cube();
  asset.materials.push_back({"skin", {1, 0.5f, 0.25f, 1}, "skin.png"});
  asset.meshes[0].groups[0].material = 0;
  asset.meshes[0].groups.push_back(asset.meshes[0].groups[0]);
  check_asset(asset);
  EXPECT_EQ(count_of(asset, "missing-uvs"), 24);
  ASSERT_EQ(asset.materials.size(), 1u);
  EXPECT_TRUE(asset.materials[0].texture.empty());
  EXPECT_EQ(asset.meshes[0].groups[1].material, 0);
}

TEST(AssetCheck, CountsWhatIsWrong) {
  // each block damages a new cube
  Asset asset = cube();
  corners(asset).insert(corners(asset).end(), {0, 0, 1, 5, 5, 5});
  EXPECT_EQ(count_after_check(asset, "zero-area"), 2);
  EXPECT_EQ(count_after_check(asset, "open"), 0);

  asset = cube();
  corners(asset).insert(corners(asset).end(), {0, 2, 3, 5, 4, 7});  // again, and again turned
  EXPECT_EQ(count_after_check(asset, "duplicate-faces"), 2);
  EXPECT_EQ(count_after_check(asset, "non-manifold"), 0);
  EXPECT_TRUE(weld(pose_surface(asset)).closed());

  asset = cube();
  corners(asset).insert(corners(asset).end(), {0, 1, 6});
  EXPECT_EQ(count_after_check(asset, "non-manifold"), 2);  // 0 1 and 0 6 have three faces
  EXPECT_EQ(count_after_check(asset, "open"), 1);          // 1 6 has one

  asset = cube();
  corners(asset).resize(33);
  EXPECT_EQ(count_after_check(asset, "open"), 3);

  asset = cube();
  std::swap(corners(asset)[0], corners(asset)[1]);
  EXPECT_EQ(count_after_check(asset, "mixed-winding"), 3);
  EXPECT_EQ(count_after_check(asset, "flipped"), 0);

  asset = cube();
  for (size_t k = 0; k < 36; k += 3) std::swap(corners(asset)[k], corners(asset)[k + 1]);
  EXPECT_EQ(count_after_check(asset, "flipped"), 12);
  EXPECT_NEAR(weld(pose_surface(asset)).volume, -1, 1e-14);

  asset = cube();
  asset.meshes[0].position.push_back({1000, 0, 0});
  asset.meshes[0].position_of.push_back(8);
  EXPECT_EQ(count_after_check(asset, "unreferenced"), 1);

  asset = cube();
  asset.nodes.push_back({"again", -1, kIdentity4, 0});
  asset.nodes[1].matrix[12] = 3;
  EXPECT_EQ(count_after_check(asset, "pieces"), 2);
}

TEST(AssetCheck, ResetsAttributesThatAreNotFinite) {
  Asset asset = cube();
  Mesh& mesh = asset.meshes[0];
  mesh.uv.assign(8, {0.5f, 0.5f});
  mesh.normal.assign(8, {1, 0, 0});
  mesh.colour.assign(8, {0, 0, 0, 1});
  mesh.uv[1][0] = mesh.normal[2][1] = mesh.colour[3][2] = mesh.colour[4][0] = float(kNan);
  check_asset(asset);
  EXPECT_EQ(count_of(asset, "bad-uvs"), 1);
  EXPECT_EQ(count_of(asset, "bad-normals"), 1);
  EXPECT_EQ(count_of(asset, "bad-colours"), 2);
  EXPECT_EQ(mesh.uv[1], (std::array<float, 2>{0, 0}));
  EXPECT_EQ(mesh.normal[2], (std::array<float, 3>{0, 0, 1}));
  EXPECT_EQ(mesh.colour[3], (std::array<float, 4>{1, 1, 1, 1}));
  mesh.uv.resize(7);
  expect_says(error_of([&] { check_asset(asset); }), "7 uvs for 8 vertices");
}

TEST(AssetCheck, FindsWhatIsWrongInRealFiles) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) return;
  struct Row {
    const char *name, *what;
    int64_t count;
  };
  const Row rows[] = {{"spot_zero_area", "zero-area", 400},
                      {"spot_zero_area", "open", 0},
                      {"spot_duplicated_faces", "duplicate-faces", 1000},
                      {"spot_duplicated_faces", "non-manifold", 0},
                      {"spot_duplicated_vertices", "duplicate-vertices", 17568 - 2930},
                      {"spot_duplicated_vertices", "open", 0},
                      {"spot_flipped", "flipped", 5856},
                      {"spot_unreferenced", "unreferenced", 5},
                      {"spot_unreferenced", "open", 0},
                      {"spot_far_1e7", "duplicate-vertices", 0},
                      {"spot_micrometres", "zero-area", 0},
                      {"spot_parsec", "zero-area", 0},
                      {"spot_headless", "open", 60},
                      {"spot_holes", "open", 749},
                      {"spot_shells", "pieces", 4},
                      {"fan3", "non-manifold", 1},
                      {"fan3", "open", 6},
                      {"hourglass_ico", "pieces", 2},
                      {"moebius", "open", 112},
                      {"open_sheet", "open", 160}};
  for (const Row& row : rows) {
    Asset asset = read_obj(folder + "broken/" + row.name + ".obj");
    check_asset(asset);
    EXPECT_EQ(count_of(asset, row.what), row.count) << row.name << ' ' << row.what;
  }
  Asset mixed = read_obj(folder + "broken/spot_mixed_winding.obj");
  check_asset(mixed);
  EXPECT_GT(count_of(mixed, "mixed-winding"), 1000);
  // cube of the scale, and the volume over it: far from the origin, micrometres, parsecs
  const double volumes[][2] = {{1, 0.718}, {1e-18, 0.718}, {27e48, 0.718}};
  const char* names[] = {"spot_far_1e7", "spot_micrometres", "spot_parsec"};
  for (int k = 0; k < 3; ++k) {
    const Surface s = pose_surface(read_obj(folder + "broken/" + names[k] + ".obj"));
    EXPECT_NEAR(weld(s).volume / volumes[k][0], volumes[k][1], 2e-3) << names[k];
  }
}

}  // namespace
}  // namespace elastogen
