// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_reader.hpp"

#include "tests/io/glb_files.hpp"

#include <cmath>

namespace elastogen {
namespace {

using test::Builder, test::error_of, test::expect_says, test::Json, test::triangle;

class GltfReader : public ::testing::Test {
 protected:
  Asset read(const Builder& builder) { return read_gltf(folder.write("a.glb", builder.file())); }
  std::string refusal(const Builder& builder) {
    return error_of([&] { read(builder); });
  }
  test::TempFolder folder;
};

TEST_F(GltfReader, ReadsWhatTheFileHolds) {
  Builder builder = triangle();
  builder.document["materials"] = {
      {{"name", "skin"},
       {"doubleSided", true},
       {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 1, 0.75}}}}}};
  builder.document["meshes"][0]["name"] = "m";
  builder.document["meshes"][0]["primitives"][0]["material"] = 0;
  const Asset asset = read(builder);
  // axes and unit of the standard
  EXPECT_EQ(asset.format, "glb");
  EXPECT_EQ(asset.up, 2);
  EXPECT_EQ(asset.unit, 1);
  // the mesh
  ASSERT_EQ(asset.meshes.size(), 1u);
  const Mesh& mesh = asset.meshes[0];
  EXPECT_EQ(mesh.name, "m");
  EXPECT_EQ(mesh.position, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.position_of, (std::vector<int32_t>{0, 1, 2}));
  EXPECT_EQ(mesh.uv[1], (std::array<float, 2>{1, 0}));
  EXPECT_EQ(mesh.normal[2], (std::array<float, 3>{0, 0, 1}));
  ASSERT_EQ(mesh.groups.size(), 1u);
  EXPECT_EQ(mesh.groups[0].corner, (std::vector<int32_t>{0, 1, 2}));
  EXPECT_EQ(mesh.groups[0].material, 0);
  // material and node
  EXPECT_EQ(asset.materials[0].name, "skin");
  EXPECT_TRUE(asset.materials[0].double_sided);
  EXPECT_EQ(asset.materials[0].base_colour, (std::array<float, 4>{0.5f, 0.25f, 1, 0.75f}));
  EXPECT_EQ(asset.nodes[0].name, "leaf");
  EXPECT_TRUE(asset.findings.empty());
}

TEST_F(GltfReader, ReadsInterleavedAndNormalisedIntegers) {
  Builder builder = triangle();
  // 8 bytes a vertex: three int16 positions, two bytes of UV, over two accessors
  const std::vector<int16_t> rows = {-32768, 0, 32767, 0x00ff, 1, 2, 3, 0x0080, 4, 5, 6, 0};
  const int view = builder.add_view(test::bytes_of(rows));
  builder.document["bufferViews"][size_t(view)]["byteStride"] = 8;
  builder.document["accessors"][0] = {{"bufferView", view},
                                      {"componentType", 5122},
                                      {"count", 3},
                                      {"type", "VEC3"},
                                      {"normalized", true}};
  builder.document["accessors"][2] = {{"bufferView", view}, {"componentType", 5121},
                                      {"count", 3},         {"type", "VEC2"},
                                      {"normalized", true}, {"byteOffset", 6}};
  const Mesh mesh = read(builder).meshes[0];
  EXPECT_EQ(mesh.position[0], (Vec3{-1, 0, 1}));
  EXPECT_EQ(mesh.position[1], (Vec3{float(1 / 32767.0), float(2 / 32767.0), float(3 / 32767.0)}));
  EXPECT_EQ(mesh.uv[0], (std::array<float, 2>{1, 0}));
  EXPECT_EQ(mesh.uv[1], (std::array<float, 2>{float(128 / 255.0), 0}));
}

TEST_F(GltfReader, ExpandsSparseAccessors) {
  Builder builder = triangle();
  const int indices = builder.add_view(test::bytes_of<uint8_t>({2}));
  const int values = builder.add_view(test::bytes_of<float>({7, 8, 9}));
  const Json sparse = {{"count", 1},
                       {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                       {"values", {{"bufferView", values}}}};
  builder.document["accessors"][0]["sparse"] = sparse;
  EXPECT_EQ(read(builder).meshes[0].position, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {7, 8, 9}}));
  builder.document["accessors"][0].erase("bufferView");
  EXPECT_EQ(read(builder).meshes[0].position, (std::vector<Vec3>{{0, 0, 0}, {0, 0, 0}, {7, 8, 9}}));
}

TEST_F(GltfReader, TurnsStripsAndFansIntoTrianglesOfOneWinding) {
  Builder builder = triangle();
  // a square in the plane z = 0, counter-clockwise seen from above
  builder.document["accessors"][0]["count"] = 4;
  builder.document["accessors"][0]["bufferView"] =
      builder.add_view(test::bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}));
  Json& primitive = builder.document["meshes"][0]["primitives"][0];
  primitive["attributes"] = {{"POSITION", 0}};
  primitive.erase("indices");
  primitive["mode"] = 5;
  EXPECT_EQ(read(builder).meshes[0].groups[0].corner, (std::vector<int32_t>{0, 1, 2, 1, 3, 2}));
  primitive["mode"] = 6;
  primitive["indices"] = builder.add<uint32_t>({0, 1, 3, 2}, "SCALAR", 5125, 4);
  EXPECT_EQ(read(builder).meshes[0].groups[0].corner, (std::vector<int32_t>{1, 3, 0, 3, 2, 0}));
  primitive["mode"] = 4;
  primitive["indices"] = builder.add<uint8_t>({3, 2, 1}, "SCALAR", 5121, 3);
  EXPECT_EQ(read(builder).meshes[0].groups[0].corner, (std::vector<int32_t>{3, 2, 1}));
}

TEST_F(GltfReader, PutsPositionAccessorsInOrderOfFirstUse) {
  Builder builder = triangle();
  const int other = builder.add_vectors({5, 0, 0, 6, 0, 0, 5, 1, 0, 9, 9, 9});
  builder.add_primitive({{"attributes", {{"POSITION", other}}}, {"mode", 0}});
  builder.add_primitive({{"attributes", {{"POSITION", other}}}, {"indices", 3}});
  builder.add_primitive({{"attributes", {{"POSITION", 0}}}, {"indices", 3}});
  const Asset asset = read(builder);
  const Mesh& mesh = asset.meshes[0];
  ASSERT_EQ(mesh.position.size(), 7u);
  EXPECT_EQ(mesh.position[6], (Vec3{9, 9, 9}));
  ASSERT_EQ(mesh.groups.size(), 3u);
  EXPECT_EQ(mesh.groups[1].primitive, 2);
  EXPECT_EQ(mesh.groups[1].corner, (std::vector<int32_t>{3, 4, 5}));
  EXPECT_EQ(mesh.groups[2].corner, (std::vector<int32_t>{0, 1, 2}));
  EXPECT_EQ(mesh.normal.size(), 7u);
  ASSERT_EQ(asset.findings.size(), 1u);
  EXPECT_EQ(asset.findings[0].what, "not-triangles");
}

TEST_F(GltfReader, ComposesNodeTransforms) {
  Builder builder = triangle();
  const double s = std::sqrt(0.5);  // a quarter turn about z
  builder.document["nodes"] = {
      {{"children", {1}}, {"translation", {1, 2, 3}}, {"rotation", {0, 0, s, s}}},
      {{"mesh", 0}, {"matrix", {2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 5, 6, 7, 1}}},
      {{"mesh", 0}, {"scale", {1, -1, 1}}}};
  const Surface surface = pose_surface(read(builder));
  ASSERT_EQ(surface.instances.size(), 2u);
  // (x, y, z) -> (2x+5, 3y+6, 4z+7) -> (-y, x, z) -> + (1, 2, 3)
  const double expected[6][3] = {{-5, 7, 10}, {-5, 9, 10}, {-8, 7, 10},
                                 {0, 0, 0},   {1, 0, 0},   {0, -1, 0}};
  for (int v = 0; v < 6; ++v) {
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(surface.vertices(v, d), expected[v][d], 1e-14);
  }
}

TEST_F(GltfReader, ShowsTheDefaultSceneOnly) {
  Builder builder = triangle();
  builder.document["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}};
  builder.document["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  builder.document["scene"] = 1;
  const Asset asset = read(builder);
  EXPECT_EQ(asset.nodes[0].mesh, -1);
  EXPECT_EQ(asset.nodes[1].mesh, 0);
}

TEST_F(GltfReader, LeavesOutTheParentThatTheSceneLeavesOut) {
  Builder builder = triangle();
  builder.document["nodes"] = {{{"children", {1}}, {"scale", {9, 9, 9}}}, {{"mesh", 0}}};
  builder.document["scenes"] = {{{"nodes", {1}}}};
  EXPECT_EQ(world_matrix(read(builder), 1), kIdentity4);
}

TEST_F(GltfReader, TakesAHundredThousandNestedNodes) {
  Builder builder = triangle();
  const int depth = 100000;
  Json nodes = Json::array();
  for (int n = 0; n < depth; ++n)
    nodes.push_back({{"children", {n + 1}}, {"translation", {1, 0, 0}}});
  nodes.push_back({{"mesh", 0}});
  builder.document["nodes"] = nodes;
  EXPECT_EQ(world_matrix(read(builder), depth)[12], depth);
}

TEST_F(GltfReader, SaysWhatItLeavesOut) {
  Builder builder = triangle();
  builder.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}};
  builder.document["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}}},
       {"samplers", {{{"input", 0}, {"output", 0}}}}}};
  builder.document["images"] = {{{"uri", "lost.png"}}};
  std::vector<std::string> what;
  for (const Finding& finding : read(builder).findings) what.push_back(finding.what);
  EXPECT_EQ(what, (std::vector<std::string>{"morph-targets", "animations", "missing-texture"}));
}

TEST_F(GltfReader, RefusesWhatItCannotRead) {
  const auto extension = [&](const char* list, const char* name) {
    Builder builder = triangle();
    builder.document[list] = {name};
    return refusal(builder);
  };
  expect_says(extension("extensionsRequired", "VENDOR_unknown"),
              "requires the extension VENDOR_unknown, which is not read; re-export without it");
  expect_says(extension("extensionsRequired", "KHR_meshopt_compression"), "re-export without it");
  Builder builder = triangle();
  builder.document["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_sheen"};
  EXPECT_NO_THROW(read(builder));
  Builder old = triangle();
  old.document["asset"]["version"] = "1.0";
  expect_says(refusal(old), "version");
}

/// A change of the triangle's document and words of its refusal.
struct Damage {
  const char* pointer;
  Json value;
  const char* message;
};

TEST_F(GltfReader, RefusesNumbersThatLeaveTheirBytes) {
  const uint64_t huge = UINT64_MAX - 7;
  // accessors, buffer views, meshes, nodes, scenes and images in turn
  const std::vector<Damage> damages = {
      {"/accessors/0/byteOffset", huge, "byteOffset"},
      {"/accessors/0/byteOffset", 4, "leave the buffer view"},
      {"/accessors/0/byteOffset", -4, "byteOffset"},
      {"/accessors/0/byteOffset", "4", "byteOffset"},
      {"/accessors/0/count", 4000000000u, "count"},
      {"/accessors/0/count", 2000000000, "leave the buffer view"},
      {"/accessors/0/count", 0, "count"},
      {"/accessors/0/count", 2.5, "count"},
      {"/accessors/0/componentType", 5130, "componentType"},
      {"/accessors/0/componentType", 5124, "componentType"},
      {"/accessors/0/type", "VEC7", "type"},
      {"/accessors/0/type", "MAT4", "matrices"},
      {"/accessors/0/type", "VEC2", "VEC3"},
      {"/accessors/0/bufferView", 99, "buffer view"},
      {"/accessors/1/count", 2, "vertices"},
      {"/accessors/3/componentType", 5126, "unsigned"},
      {"/accessors/3/componentType", 5122, "unsigned"},
      {"/bufferViews/0/byteOffset", huge, "byteOffset"},
      {"/bufferViews/0/byteLength", huge, "byteLength"},
      {"/bufferViews/0/byteLength", 1000, "leaves the buffer"},
      {"/bufferViews/0/byteStride", 8, "smaller than an element"},
      {"/bufferViews/0/byteStride", 248, "leave the buffer view"},
      {"/bufferViews/0/buffer", 1, "buffer"},
      {"/meshes/0/primitives/0/indices", 77, "ndices"},
      {"/meshes/0/primitives/0/material", 0, "material"},
      {"/meshes/0/primitives/0/attributes/POSITION", 77, "no such accessor"},
      {"/meshes/0/primitives/0/attributes/POSITION", -1, "non-negative"},
      {"/meshes/0/primitives/0/attributes", 3, "attributes"},
      {"/meshes/0/primitives", 3, "primitives"},
      {"/meshes/0", nullptr, "meshes"},
      {"/nodes/0/mesh", 1, "no mesh"},
      {"/nodes/0/children", {5}, "no node"},
      {"/nodes/0/children", {0}, "cycle"},
      {"/nodes/0/matrix", {1, 2, 3}, "transform"},
      {"/nodes/0/matrix", std::vector<int>(16, 1), "last row"},
      {"/nodes/0/rotation", {0, 0, 0, 0}, "quaternion"},
      {"/nodes/0/scale", {"a", 1, 1}, "numbers"},
      {"/scenes", {{{"nodes", {3}}}}, "no node"},
      {"/scenes", {{{"nodes", {0, 0}}}}, "twice"},
      {"/scene", "first", "scene"},
      {"/images", {{{"uri", "../a.png"}}}, "leaves"}};
  for (const Damage& damage : damages) {
    Builder builder = triangle();
    builder.document[Json::json_pointer(damage.pointer)] = damage.value;
    expect_says(refusal(builder), damage.message);
  }
}

TEST_F(GltfReader, RefusesIndicesOutOfRange) {
  Builder builder = triangle();
  builder.document["meshes"][0]["primitives"][0]["indices"] =
      builder.add<uint16_t>({0, 1, 3}, "SCALAR", 5123, 3);
  expect_says(refusal(builder), "vertex index 3 is out of range");
}

TEST_F(GltfReader, RefusesSparseAccessorsThatOverflow) {
  const auto with = [&](const char* pointer, const Json& value) {
    Builder builder = triangle();
    const int view = builder.add_view(test::bytes_of<uint32_t>({0xffffffffu, 0, 0, 0}));
    builder.document["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", view}, {"componentType", 5121}, {"byteOffset", 4}}},
        {"values", {{"bufferView", view}}}};
    builder.document["accessors"][0]["sparse"][Json::json_pointer(pointer)] = value;
    return refusal(builder);
  };
  expect_says(with("/count", 4), "sparse count");
  expect_says(with("/count", 0), "sparse count");
  expect_says(with("/indices/byteOffset", UINT64_MAX - 7), "byteOffset");
  expect_says(with("/indices/byteOffset", 0), "sparse index");
  expect_says(with("/values/byteOffset", 8), "leave the buffer view");
  expect_says(with("/indices/componentType", 5126), "unsigned");
  expect_says(with("/indices", 3), "object");
  expect_says(with("/values/bufferView", 99), "buffer view");
}

TEST_F(GltfReader, RefusesAClaimWithoutBytes) {
  Builder builder = triangle();
  builder.document["accessors"][0].erase("bufferView");
  builder.document["accessors"][0]["count"] = 2000000000;
  expect_says(refusal(builder), "larger than the file");
  Builder reused = triangle();
  for (int i = 0; i < 20000; ++i)
    reused.add_primitive({{"attributes", {{"POSITION", 0}}}, {"indices", 3}});
  expect_says(refusal(reused), "more often");
}

TEST_F(GltfReader, RefusesCyclesAndTwoParents) {
  Builder builder = triangle();
  builder.document["nodes"] = {{{"mesh", 0}}, {{"children", {2}}}, {{"children", {1}}}};
  expect_says(refusal(builder), "cycle");
  builder.document["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
  expect_says(refusal(builder), "two parents");
}

TEST_F(GltfReader, RefusesJsonThatIsNestedTooDeeply) {
  const std::string deep =
      "{\"asset\":{\"version\":\"2.0\"},\"extras\":" + std::string(100000, '[') +
      std::string(100000, ']') + "}";
  const std::string path = folder.write("deep.gltf", deep);
  expect_says(error_of([&] { read_gltf(path); }), "nested deeper");
}

TEST_F(GltfReader, KeepsNotANumberForTheCheckThatFollows) {
  Builder builder = triangle();
  builder.document["accessors"][0]["bufferView"] =
      builder.add_view(test::bytes_of<float>({NAN, 0, 0, 1, 0, 0, 0, 1, INFINITY}));
  EXPECT_TRUE(std::isnan(read(builder).meshes[0].position[0][0]));
}

TEST_F(GltfReader, RefusesEveryTruncation) {
  const std::string whole = triangle().file();
  for (size_t size = 0; size < whole.size(); ++size) {
    const std::string path = folder.write("cut.glb", whole.substr(0, size));
    error_of([&] { read_gltf(path); });
  }
}

TEST_F(GltfReader, SurvivesAnyDamagedByte) {
  const std::string whole = triangle().file();
  int refused = 0;
  for (size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = char(damaged[i] ^ (0x11 << (i % 4)));
    const std::string path = folder.write("damaged.glb", damaged);
    try {
      read_gltf(path);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset);
      ++refused;
    }
  }
  EXPECT_GT(refused, int(whole.size() / 4));
}

TEST_F(GltfReader, ReadsRealFiles) {
  const std::string assets = test::assets_folder();
  if (assets.empty()) return;
  const std::vector<std::pair<const char*, int64_t>> triangles = {
      {"gltf/CesiumMilkTruck.glb", 3624},     {"gltf/SheenCloth.glb", 115200},
      {"gltf/cakeBirthday.glb", 1332},        {"gltf/nested.glb", 36},
      {"gltf/palmtree/PalmTree.gltf", 10124}, {"gltf/spot_nodes.glb", 17568},
      {"gltf/spot_quantized.glb", 5856},      {"generators/trellis_sample.glb", 10854}};
  for (const auto& [name, count] : triangles)
    EXPECT_EQ(pose_surface(read_gltf(assets + name)).triangles.rows(), count) << name;
  const Box truck = pose_surface(read_gltf(assets + "gltf/CesiumMilkTruck.glb")).box;
  EXPECT_NEAR(truck.extent(0), 4.87, 0.005);
  EXPECT_NEAR(truck.extent(2), 2.79, 0.005);
}

}  // namespace
}  // namespace elastogen
