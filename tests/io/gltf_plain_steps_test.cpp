// SPDX-License-Identifier: Apache-2.0
// Instances, morph weights and animations of a source: which are simulated, which the output keeps.
#include "tests/io/glb_clip.hpp"

namespace elastogen {
namespace {

using test::Builder, test::error_of, test::expect_says, test::GlbFile, test::Json, test::triangle;
using GltfSteps = test::GlbClip;

const Finding* finding_of(const Asset& asset, const std::string& what) {
  for (const Finding& finding : asset.findings)
    if (finding.what == what) return &finding;
  return nullptr;
}

/// Two instances below a scaled node: moved by (3, 0, 0), and turned by a quarter about z.
Builder instanced() {
  Builder builder = triangle();
  const int translation = builder.add_vectors({3, 0, 0, 0, 0, 0});
  const int rotation = builder.add<int8_t>({0, 0, 0, 127, 0, 0, 90, 90}, "VEC4", 5120, 2);
  builder.document["accessors"].back()["normalized"] = true;
  const int id = builder.add<float>({1, 2}, "SCALAR", 5126, 2);
  builder.document["nodes"][0]["scale"] = {2, 2, 2};
  builder.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", translation}, {"ROTATION", rotation}, {"_ID", id}};
  builder.document["extensionsUsed"] = builder.document["extensionsRequired"] =
      Json::array({"EXT_mesh_gpu_instancing"});
  return builder;
}

TEST_F(GltfSteps, EachInstanceIsANode) {
  const Asset asset = read(instanced());
  ASSERT_EQ(asset.nodes.size(), 3u);
  EXPECT_EQ(asset.nodes[0].mesh, -1);
  EXPECT_EQ(asset.nodes[1].name, "leaf_instance_1");
  ASSERT_TRUE(finding_of(asset, "instances"));
  EXPECT_EQ(finding_of(asset, "instances")->count, 2);
  expect_says(finding_of(asset, "instance-attributes")->text, "_ID");
  const Surface surface = pose_surface(asset);
  ASSERT_EQ(surface.instances.size(), 2u);
  const double expected[6][2] = {{6, 0}, {8, 0}, {6, 2}, {0, 0}, {0, 2}, {-2, 0}};
  for (int64_t v = 0; v < 6; ++v)
    for (int d = 0; d < 2; ++d) EXPECT_NEAR(surface.vertices(v, d), expected[v][d], 1e-12);
  const GlbFile file = animate(asset, surface, {});
  EXPECT_LT(shown_error(file, asset, surface), 0.02);
  EXPECT_FALSE(file.document.contains("extensionsUsed"));
  EXPECT_FALSE(file.document.contains("extensionsRequired"));
  EXPECT_FALSE(file.document["nodes"][0].contains("extensions"));
}

TEST_F(GltfSteps, RefusesInstancesThatDoNotFit) {
  const auto with = [&](const char* pointer, const Json& value) {
    Builder builder = instanced();
    builder.document[Json::json_pointer(pointer)] = value;
    return error_of([&] { read(builder); });
  };
  const std::string at = "/nodes/0/extensions/EXT_mesh_gpu_instancing";
  expect_says(with("/accessors/4/count", 1), "instances, another attribute");
  expect_says(with("/accessors/4/count", 0), "has no instance");
  expect_says(with("/accessors/4/count", 3), "instances, another attribute");
  expect_says(with("/accessors/5/normalized", false), "must be floats, or normalised integers");
  expect_says(with((at + "/attributes/ROTATION").c_str(), 4), "must have 4 numbers");
  expect_says(with((at + "/attributes/TRANSLATION").c_str(), 99), "there is no accessor 99");
  expect_says(with((at + "/attributes/TRANSLATION").c_str(), -1), "non-negative integer");
  expect_says(with((at + "/attributes").c_str(), Json::object()),
              "nodes[0].EXT_mesh_gpu_instancing");
  expect_says(with(at.c_str(), 3), "it has no attributes");
  expect_says(with("/nodes/0/skin", 0), "skinned mesh");
  // a claim without bytes
  expect_says(
      with("/accessors/4", {{"componentType", 5126}, {"count", 2000000000}, {"type", "VEC3"}}),
      "instances, another attribute");
}

/// Two nodes of one mesh: weights of the mesh (0.5, 0), of the second node (0, 1).
Builder morphed() {
  Builder builder = triangle();
  const int move = builder.add_vectors({0, 0, 2, 0, 0, 2, 0, 0, 2});
  const int turn = builder.add_vectors({1, 0, -1, 1, 0, -1, 1, 0, -1});
  // sparse: vertex 1 moves by (0, 0, 4)
  const int index = builder.add_view(test::bytes_of<uint16_t>({1}));
  const int value = builder.add_view(test::bytes_of<float>({0, 0, 4}));
  builder.document["accessors"].push_back(
      {{"componentType", 5126},
       {"count", 3},
       {"type", "VEC3"},
       {"sparse",
        {{"count", 1},
         {"indices", {{"bufferView", index}, {"componentType", 5123}}},
         {"values", {{"bufferView", value}}}}}});
  const int sparse = int(builder.document["accessors"].size()) - 1;
  Json& mesh = builder.document["meshes"][0];
  mesh["primitives"][0]["targets"] = {{{"POSITION", move}},
                                      {{"POSITION", sparse}, {"NORMAL", turn}}};
  mesh["weights"] = {0.5, 0};
  mesh["extras"]["targetNames"] = {"up", "tip"};
  builder.document["nodes"] = {{{"name", "a"}, {"mesh", 0}},
                               {{"name", "b"}, {"mesh", 0}, {"weights", {0, 1}}}};
  return builder;
}

TEST_F(GltfSteps, WeightsOfMorphTargetsGiveTheRestShape) {
  const Asset asset = read(morphed());
  ASSERT_EQ(asset.meshes.size(), 2u);
  const Mesh& a = asset.meshes[size_t(asset.nodes[0].mesh)];
  const Mesh& b = asset.meshes[size_t(asset.nodes[1].mesh)];
  EXPECT_EQ(a.position, (std::vector<Vec3>{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}));
  EXPECT_EQ(b.position, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 4}, {0, 1, 0}}));
  EXPECT_EQ(a.normal[0], (std::array<float, 3>{0, 0, 1}));
  EXPECT_EQ(b.normal[0], (std::array<float, 3>{1, 0, 0}));
  ASSERT_TRUE(finding_of(asset, "morph-weights"));
  EXPECT_EQ(finding_of(asset, "morph-weights")->text,
            "nodes are shown with weights of morph targets: a, b");
  EXPECT_EQ(finding_of(asset, "morph-targets")->count, 1);
  for (const bool keyframe : {false, true}) {
    const GlbFile file = animate(asset, pose_surface(asset), {.keyframe = keyframe});
    for (const size_t node : {0, 1}) {
      const Json& mesh = file.mesh_of(node);
      EXPECT_EQ(mesh["extras"]["targetNames"].size(), mesh["weights"].size());
      EXPECT_EQ(mesh["primitives"][0]["targets"].size(), mesh["weights"].size());
      EXPECT_NE(mesh["extras"]["targetNames"][0], "up");
    }
  }
}

TEST_F(GltfSteps, RefusesWeightsThatDoNotFit) {
  const auto with = [&](const char* pointer, const Json& value) {
    Builder builder = morphed();
    builder.document[Json::json_pointer(pointer)] = value;
    return error_of([&] { read(builder); });
  };
  expect_says(with("/meshes/0/weights", {1}), "meshes[0] has 1 weights");
  expect_says(with("/nodes/1/weights", {1, "x"}), "nodes[1]: its weights must be finite numbers");
  expect_says(with("/nodes/1/weights", 3), "nodes[1]: its weights are no list");
  expect_says(with("/accessors/4/count", 2), "targets[0].POSITION has 2 x 3 numbers");
  expect_says(with("/meshes/0/primitives/0/targets/0/POSITION", 77), "there is no accessor 77");
  expect_says(with("/meshes/0/primitives/0/targets/0", 7), "a target is no object");
}

TEST_F(GltfSteps, AnimationsOfWhatIsNotSimulatedAreKept) {
  Builder builder = triangle();
  const int times = builder.add<float>({0, 1}, "SCALAR", 5126, 2);
  const int places = builder.add_vectors({0, 0, 0, 0, 0, 5});
  // a body between its parent and a camera
  builder.document["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
  builder.document["nodes"] = {{{"name", "top"}, {"children", {1}}},
                               {{"name", "body"}, {"mesh", 0}, {"children", {2}}},
                               {{"name", "camera"}, {"camera", 0}}};
  const Json sampler = {{"input", times}, {"output", places}};
  const auto channel = [](int used, int node) {
    return Json{{"sampler", used}, {"target", {{"node", node}, {"path", "translation"}}}};
  };
  // channels of parent and camera, of the body, and broken ones
  builder.document["animations"] = {{{"name", "fly"},
                                     {"samplers", {sampler, sampler}},
                                     {"channels", {channel(0, 0), channel(1, 2)}}},
                                    {{"name", "jump"},
                                     {"samplers", {sampler}},
                                     {"channels", {channel(0, 1), channel(9, 2), channel(0, 7)}}}};
  // only the camera's channel is kept
  const Asset asset = read(builder);
  ASSERT_TRUE(finding_of(asset, "animations"));
  EXPECT_EQ(finding_of(asset, "animations")->count, 4);
  const GlbFile file = animate(asset, pose_surface(asset), {});
  const Json& animations = file.document["animations"];
  ASSERT_EQ(animations.size(), 2u);
  EXPECT_EQ(animations[0]["name"], "elastogen");
  EXPECT_EQ(animations[1]["name"], "fly");
  EXPECT_EQ(animations[1]["channels"], Json::array({channel(0, 2)}));
  EXPECT_EQ(animations[1]["samplers"], Json::array({sampler}));
}

TEST_F(GltfSteps, NormalsGetTheLengthOneInTheOutputToo) {
  // triangles, strip and fan: one normal too long, one of length zero, one packed
  for (const int mode : {4, 5, 6}) {
    Builder builder = triangle();
    Json& primitive = builder.document["meshes"][0]["primitives"][0];
    primitive["mode"] = mode;
    primitive["attributes"]["NORMAL"] = builder.add_vectors({0, 0.6f, 1.6f, 0, 0, 0, 0, 0, 1.005f});
    const Asset asset = read(builder);
    ASSERT_TRUE(finding_of(asset, "zero-normals"));
    EXPECT_EQ(finding_of(asset, "zero-normals")->count, 1);
    EXPECT_EQ(finding_of(asset, "long-normals")->count, 1);
    expect_says(finding_of(asset, "long-normals")->text, "meshes[0].primitives[0]");
    const auto& normal = asset.meshes[0].normal;
    ASSERT_EQ(normal.size(), 3u);
    for (const auto& n : normal) EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-6);
    EXPECT_NEAR(normal[0][1] / normal[0][2], 0.375, 1e-6);
    EXPECT_NEAR(normal[1][2], 1, 1e-6);  // of the triangle, which runs from x to y
    const GlbFile file = animate(asset, pose_surface(asset), {});
    const int written = file.mesh_of(0)["primitives"][0]["attributes"]["NORMAL"];
    for (const std::vector<double>& n : file.floats(written))
      EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-6);
  }
  // rounding stays as it is
  Builder rounded = triangle();
  rounded.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      rounded.add_vectors({0, 0, 1.0004f, 0, 0, 1, 0, 0, 0.9996f});
  EXPECT_EQ(read(rounded).meshes[0].normal[0][2], 1.0004f);
  // packed normals are mended but not counted
  Builder packed = triangle();
  packed.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      packed.add_vectors({0, 0, 1.005f, 0, 0, 1, 0, 0, 0.995f});
  const Asset asset = read(packed);
  EXPECT_FALSE(finding_of(asset, "long-normals"));
  EXPECT_EQ(asset.meshes[0].normal[0][2], 1);
}

TEST_F(GltfSteps, RefusesNormalsThatDoNotFit) {
  Builder builder = triangle();
  Json& attributes = builder.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["NORMAL"] = builder.add<float>({0, 0, 0, 0, 0, 0}, "VEC2", 5126, 3);
  expect_says(error_of([&] { read(builder); }), "meshes[0].primitives[0]");
}

}  // namespace
}  // namespace elastogen
