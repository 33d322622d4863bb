// SPDX-License-Identifier: Apache-2.0
#include "io/plain_gltf.hpp"

#include "core/error.hpp"
#include "io/glb_document.hpp"
#include "io/gltf_reader.hpp"
#include "tests/io/glb_files.hpp"

#include <cmath>

namespace elastogen {
namespace {

using test::Builder, test::error_of, test::expect_says, test::Json, test::triangle;

class PlainGltf : public ::testing::Test {
 protected:
  Asset read(const Builder& builder) { return read_gltf(folder.write("a.glb", builder.file())); }
  std::string refusal(const Builder& builder) {
    return error_of([&] { read(builder); });
  }
  /// The document that a writer starts from.
  Json document(const Builder& builder) { return Json::parse(gltf_document(read(builder)).json); }
  test::TempFolder folder;
};

/// The triangle with two joints: node 1 moves by (1, 0, 0), node 2 turns by a quarter about z and
/// moves by (0, 2, 0); the inverse bind matrices are the identity and a move by (0, 0, 5).
/// @param weights  four a vertex, of the joints {0, 1, 0, 0} of the skin.
Builder skinned(const std::vector<float>& weights) {
  Builder builder = triangle();
  const double s = std::sqrt(0.5);
  builder.document["nodes"] = {
      {{"name", "body"}, {"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}},
      {{"translation", {1, 0, 0}}},
      {{"translation", {0, 2, 0}}, {"rotation", {0, 0, s, s}}}};
  builder.document["scenes"] = {{{"nodes", {0, 1, 2}}}};
  std::vector<float> bind(32, 0);
  for (size_t i = 0; i < 4; ++i) bind[5 * i] = bind[16 + 5 * i] = 1;
  bind[16 + 14] = 5;
  const int matrices = builder.add(bind, "MAT4", 5126, 2);
  builder.document["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", matrices}}};
  Json& attributes = builder.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] =
      builder.add<uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4", 5121, 3);
  attributes["WEIGHTS_0"] = builder.add(weights, "VEC4", 5126, 3);
  return builder;
}

TEST_F(PlainGltf, AScenesRootsHaveNoParent) {
  // as some exporters write it: the scene names the child of a helper; and a root's own child
  Builder builder = triangle();
  builder.document["nodes"] = {{{"name", "helper"}, {"children", {1}}, {"scale", {2, 2, 2}}},
                               {{"name", "body"}, {"children", {2}}, {"translation", {3, 0, 0}}},
                               {{"name", "leaf"}, {"mesh", 0}}};
  builder.document["scenes"] = {{{"nodes", {1, 2}}}};
  const Asset asset = read(builder);
  ASSERT_EQ(asset.findings.size(), 1u);
  EXPECT_EQ(asset.findings[0].what, "scene-roots");
  EXPECT_EQ(asset.findings[0].count, 2);
  const Json plain = document(builder);
  EXPECT_EQ(plain["scenes"][0]["nodes"], (std::vector<int>{1}));
  EXPECT_FALSE(plain["nodes"][0].contains("children"));
  const Surface surface = pose_surface(asset);
  EXPECT_EQ(surface.instances.size(), 1u);
  EXPECT_EQ(surface.box.upper[0], 4);
}

TEST_F(PlainGltf, LeavesAPlainDocumentAlone) {
  Builder builder = triangle();
  builder.document["extensionsUsed"] = {"KHR_texture_basisu"};
  builder.document["extensionsRequired"] = {"KHR_texture_basisu"};
  const GltfSource before = read_gltf_source(folder.write("a.glb", builder.file()));
  std::vector<Finding> findings;
  const GltfSource after = plain_gltf(before, findings);
  EXPECT_EQ(Json::parse(before.json), Json::parse(after.json));
  EXPECT_EQ(before.buffers, after.buffers);
  EXPECT_TRUE(findings.empty());
}

// quantized attributes

TEST_F(PlainGltf, WidensQuantizedAttributes) {
  Builder builder = triangle();
  // positions of three uint16, normals of three normalised int8, UVs of two int16
  const int position =
      builder.add<uint16_t>({0, 0, 0, 9, 65535, 0, 0, 0, 0, 7, 3, 9}, "VEC3", 5123, 3);
  builder.document["bufferViews"].back()["byteStride"] = 8;
  const int normal =
      builder.add<int8_t>({0, 0, 127, 9, 0, -128, 0, 9, 127, 0, 0, 9}, "VEC3", 5120, 3);
  builder.document["bufferViews"].back()["byteStride"] = 4;
  builder.document["accessors"].back()["normalized"] = true;
  const int uv = builder.add<int16_t>({0, -4, 5, 6, 7, 8}, "VEC2", 5122, 3);
  Json& attributes = builder.document["meshes"][0]["primitives"][0]["attributes"];
  attributes = {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}};
  builder.document["extensionsUsed"] = {"KHR_mesh_quantization", "KHR_materials_ior"};
  builder.document["extensionsRequired"] = {"KHR_mesh_quantization"};

  const Mesh mesh = read(builder).meshes.at(0);
  EXPECT_EQ(mesh.position, (std::vector<Vec3>{{0, 0, 0}, {65535, 0, 0}, {0, 7, 3}}));
  EXPECT_EQ(mesh.normal[1], (std::array<float, 3>{0, -1, 0}));
  EXPECT_EQ(mesh.uv[0], (std::array<float, 2>{0, -4}));
  const Json plain = document(builder);
  EXPECT_EQ(plain["extensionsUsed"], Json::array({"KHR_materials_ior"}));
  EXPECT_FALSE(plain.contains("extensionsRequired"));
  const Json& accessor = plain["accessors"][size_t(position)];
  EXPECT_EQ(accessor["componentType"], 5126);
  EXPECT_EQ(accessor["min"], Json({0, 0, 0}));
  EXPECT_EQ(accessor["max"], Json({65535, 7, 3}));
  EXPECT_FALSE(plain["accessors"][size_t(normal)].contains("normalized"));
}

TEST_F(PlainGltf, KeepsTexcoordsThatGltfItselfAllows) {
  Builder builder = triangle();
  const int uv = builder.add<uint16_t>({0, 0, 65535, 0, 0, 65535}, "VEC2", 5123, 3);
  builder.document["accessors"].back()["normalized"] = true;
  builder.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uv;
  EXPECT_EQ(document(builder)["accessors"][size_t(uv)]["componentType"], 5123);
}

// skins

TEST_F(PlainGltf, PosesASkinnedMesh) {
  // vertex 0 follows joint 0, vertex 1 joint 1, vertex 2 both with weights that sum to 4
  const Builder builder = skinned({1, 0, 0, 0, 0, 1, 0, 0, 1, 3, 0, 0});
  const Asset asset = read(builder);
  ASSERT_EQ(asset.meshes.size(), 1u);
  ASSERT_EQ(asset.nodes.size(), 4u);
  EXPECT_EQ(asset.nodes[0].mesh, -1);
  EXPECT_EQ(asset.nodes[3].mesh, 0);
  EXPECT_EQ(asset.nodes[3].parent, -1);
  EXPECT_EQ(asset.nodes[3].matrix, kIdentity4);
  EXPECT_EQ(asset.nodes[3].name, "body");
  // joint 1 takes (x, y, z) to (-y, x + 2, z + 5); the node's own move by 100 has no part
  const double expected[3][3] = {{1, 0, 0}, {0, 3, 5}, {(1 - 3.0) / 4, (1 + 6.0) / 4, 15.0 / 4}};
  for (size_t v = 0; v < 3; ++v) {
    for (size_t d = 0; d < 3; ++d)
      EXPECT_NEAR(asset.meshes[0].position[v][d], expected[v][d], 1e-6);
    EXPECT_NEAR(asset.meshes[0].normal[v][2], 1, 1e-6);
  }
  ASSERT_EQ(asset.findings.size(), 1u);
  EXPECT_EQ(asset.findings[0].what, "skins");
  EXPECT_EQ(asset.findings[0].count, 1);
  const Json plain = document(builder);
  EXPECT_FALSE(plain.contains("skins"));
  EXPECT_FALSE(plain["nodes"][0].contains("skin"));
  EXPECT_FALSE(plain["nodes"][0].contains("mesh"));
  EXPECT_FALSE(plain["meshes"][0]["primitives"][0]["attributes"].contains("JOINTS_0"));
  EXPECT_FALSE(plain["meshes"][0]["primitives"][0]["attributes"].contains("WEIGHTS_0"));
  EXPECT_EQ(plain["scenes"][0]["nodes"], Json({0, 1, 2, 3}));
}

TEST_F(PlainGltf, TurnsNormalsAgainstAStretch) {
  Builder builder = skinned({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});
  builder.document["nodes"][2] = {{"scale", {4, 1, -1}}};
  builder.document["accessors"][1]["bufferView"] =
      builder.add_view(test::bytes_of<float>({0.6f, 0.8f, 0, 0, 0, 1, 1, 0, 0}));
  const Mesh mesh = read(builder).meshes.at(0);
  // M^-T (0.6, 0.8, 0) = (0.15, 0.8, 0); (0, 0, 1) turns over
  const double length = std::hypot(0.15, 0.8);
  EXPECT_NEAR(mesh.normal[0][0], 0.15 / length, 1e-6);
  EXPECT_NEAR(mesh.normal[0][1], 0.8 / length, 1e-6);
  EXPECT_NEAR(mesh.normal[1][2], -1, 1e-6);
}

TEST_F(PlainGltf, LetsAVertexWithoutWeightsFollowItsFirstJoint) {
  const Mesh mesh = read(skinned({0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0})).meshes.at(0);
  EXPECT_EQ(mesh.position[0], (Vec3{1, 0, 0}));
}

TEST_F(PlainGltf, PosesAMeshForEachNodeThatShowsIt) {
  Builder builder = skinned({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  builder.document["skins"].push_back({{"joints", {2, 1}}});
  builder.document["nodes"].push_back({{"mesh", 0}, {"skin", 1}});
  builder.document["nodes"].push_back({{"mesh", 0}});
  builder.document["scenes"][0]["nodes"] = {0, 1, 2, 3, 4};
  const Asset asset = read(builder);
  ASSERT_EQ(asset.meshes.size(), 3u);
  EXPECT_EQ(asset.meshes[size_t(asset.nodes[4].mesh)].position[1], (Vec3{1, 0, 0}));
  int posed = 0;
  for (size_t n = 5; n < 7; ++n) {
    const Vec3 first = asset.meshes[size_t(asset.nodes[n].mesh)].position[0];
    posed += first == Vec3{1, 0, 0} ? 1 : first == Vec3{0, 2, 0} ? 2 : 0;
  }
  EXPECT_EQ(posed, 3);
  EXPECT_EQ(asset.findings[0].count, 2);
}

TEST_F(PlainGltf, RefusesSkinsThatDoNotFit) {
  const std::vector<float> weights = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  const auto with = [&](const char* pointer, const Json& value) {
    Builder builder = skinned(weights);
    builder.document[Json::json_pointer(pointer)] = value;
    return refusal(builder);
  };
  // the skin
  expect_says(with("/nodes/0/skin", 1), "skins[1] does not exist");
  expect_says(with("/skins/0", 3), "no list of joints");
  expect_says(with("/skins/0/joints", {1, 9}), "no node for one of its joints");
  expect_says(with("/skins/0/joints", {1, -2}), "no node for one of its joints");
  expect_says(with("/skins/0/joints", {1}), "joint index 1 is out of range; the skin has 1");
  expect_says(with("/skins/0/joints", {1, 2, 1}), "more joints than inverse bind matrices");
  expect_says(with("/skins/0/inverseBindMatrices", 0), "4x4 matrices");
  expect_says(with("/skins/0/inverseBindMatrices", 99), "no accessor 99");
  // joints and weights
  expect_says(with("/accessors/5/count", 2), "for each of 3 vertices");
  expect_says(with("/accessors/1/count", 2), "for each of 3 vertices");
  expect_says(with("/nodes/1/children", {1}), "cycle");
  const char* attribute = "/meshes/0/primitives/0/attributes";
  expect_says(with(attribute, {{"POSITION", 0}}), "no JOINTS_0");
  expect_says(with(attribute, {{"POSITION", 0}, {"JOINTS_0", 5}}), "no such accessor");
  // weights that are negative or not finite
  for (const float wrong : {-1.0f, NAN, INFINITY}) {
    std::vector<float> bad = weights;
    bad[4] = wrong;
    expect_says(refusal(skinned(bad)), "must be finite and not negative");
  }
}

TEST_F(PlainGltf, TakesAHundredThousandNestedJoints) {
  Builder builder = skinned({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  const int depth = 100000;
  Json& nodes = builder.document["nodes"];
  for (int n = 3; n < depth; ++n) nodes.push_back({{"children", {n + 1}}, {"scale", {-1, -1, 1}}});
  nodes.push_back({{"translation", {0, 0, 1}}});
  builder.document["nodes"][1]["children"] = {3};
  builder.document["skins"][0]["joints"] = {depth, 2};
  // an odd number of half turns about z
  EXPECT_EQ(read(builder).meshes.at(0).position[1], (Vec3{0, 0, 1}));
}

TEST_F(PlainGltf, RefusesOneMeshPosedEndlessly) {
  Builder builder = skinned({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  Json& attributes = builder.document["meshes"][0]["primitives"][0]["attributes"];
  const Json joints = attributes["JOINTS_0"], weights = attributes["WEIGHTS_0"];
  for (int set = 1; set < 3000; ++set) {
    attributes[concat("JOINTS_", set)] = joints;
    attributes[concat("WEIGHTS_", set)] = weights;
  }
  for (int n = 0; n < 3000; ++n) {
    builder.document["nodes"].push_back({{"mesh", 0}, {"skin", 0}});
    builder.document["scenes"][0]["nodes"].push_back(n + 3);
  }
  expect_says(refusal(builder), "more often than any real file");
}

// real files

TEST_F(PlainGltf, ReadsRealFiles) {
  const std::string assets = test::assets_folder();
  if (assets.empty()) GTEST_SKIP();
  // volume by the divergence theorem
  const auto volume = [&](const char* name) {
    const Surface surface = pose_surface(read_gltf(assets + name));
    double six = 0;
    for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
      const auto corner = [&](int c) { return surface.vertices.row(surface.triangles(t, c)); };
      const double *a = corner(0), *b = corner(1), *c = corner(2);
      six += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
             a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return six / 6;
  };
  EXPECT_NEAR(volume("gltf/spot_draco.glb"), 0.718, 0.0005);
  EXPECT_NEAR(volume("gltf/spot_quantized.glb"), 0.718, 0.0005);
  EXPECT_NEAR(volume("gltf/heart_draco.glb"), 0.00011, 0.000005);
  // counts of triangles and vertices, and findings
  const Surface pirate = pose_surface(read_gltf(assets + "gltf/pirate_meshopt.glb"));
  EXPECT_EQ(pirate.triangles.rows(), 5010);
  EXPECT_EQ(pirate.vertices.rows(), 2887);
  const Asset fox = read_gltf(assets + "gltf/Fox.glb");
  EXPECT_EQ(pose_surface(fox).triangles.rows(), 576);
  EXPECT_EQ(fox.findings.back().what, "animations");
  EXPECT_EQ(fox.findings.front().what, "skins");
}

}  // namespace
}  // namespace elastogen
