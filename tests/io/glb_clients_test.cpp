// SPDX-License-Identifier: Apache-2.0
// Needs of programs that play an animated GLB, beyond what the format requires.
#include "io/animation_writer.hpp"
#include "io/asset_pose.hpp"
#include "io/morph_targets.hpp"
#include "tests/io/glb_clip.hpp"

#include <set>

namespace elastogen {
namespace {

using test::Builder, test::expect_says, test::GlbFile, test::instances, test::Json, test::kFrames;
using test::Rows, test::triangle, test::wave;
using GlbClients = test::GlbClip;

/// Below a node that shows a mesh another one does, as the wheels of a truck.
Builder truck() {
  Builder builder = triangle();
  builder.document["meshes"][0]["extras"] = {{"targetNames", {"smile"}}, {"mine", 1}};
  builder.document["nodes"] = {{{"name", "body"}, {"mesh", 0}, {"children", {1, 2}}},
                               {{"name", "axle"}, {"children", {3}}, {"translation", {0, 7, 0}}},
                               {{"name", "lamp"}, {"mesh", 0}, {"translation", {0, 0, 8}}},
                               {{"name", "body_mesh"}, {"mesh", 0}, {"translation", {9, 0, 0}}}};
  return builder;
}

TEST_F(GlbClients, ANodeThatPlaysHasNoMeshBelowIt) {
  const Asset asset = read(truck());
  const Surface surface = pose_surface(asset);
  const GlbFile file = animate(asset, surface, {});
  const Json& nodes = file.document["nodes"];
  // no node that plays has a mesh below it: node 0 hands its mesh to a child
  std::set<size_t> played, meshes;
  for (const Json& channel : file.document["animations"][0]["channels"])
    played.insert(channel["target"]["node"].get<size_t>());
  EXPECT_EQ(played, (std::set<size_t>{2, 3, 4}));
  EXPECT_FALSE(nodes[0].contains("mesh"));
  EXPECT_EQ(nodes[0]["children"], (std::vector<size_t>{1, 2, 4}));
  std::set<std::string> names;
  for (const Json& node : nodes) names.insert(node["name"].get<std::string>());
  EXPECT_EQ(names.size(), nodes.size());
  // each has a mesh of its own with targets, extras and an empty material
  for (const size_t n : played) {
    const Json& mesh = file.mesh_of(n);
    EXPECT_TRUE(meshes.insert(nodes[n]["mesh"].get<size_t>()).second);
    const size_t targets = mesh["primitives"][0]["targets"].size();
    EXPECT_GT(targets, 0u);
    EXPECT_EQ(mesh["extras"]["targetNames"].size(), targets);
    EXPECT_EQ(mesh["extras"]["mine"], 1);
    EXPECT_EQ(file.document["materials"][mesh["primitives"][0]["material"].get<size_t>()],
              Json::object());
  }
  EXPECT_LT(shown_error(file, asset, surface), 2e-3);
}

TEST_F(GlbClients, AChainOfAHundredThousandNodesIsNoFault) {
  Builder builder = triangle();
  Json nodes = Json::array({{{"name", "top"}, {"mesh", 0}, {"children", {1}}}});
  for (int n = 1; n < 100000; ++n) nodes.push_back({{"children", {n + 1}}});
  nodes.push_back({{"name", "end"}, {"mesh", 0}, {"translation", {0, 0, 3}}});
  builder.document["nodes"] = nodes;
  const Asset asset = read(builder);
  const GlbFile file = animate(asset, pose_surface(asset), {});
  EXPECT_FALSE(file.document["nodes"][0].contains("mesh"));
  EXPECT_TRUE(file.document["nodes"][100001].contains("mesh"));
}

TEST_F(GlbClients, EachTargetIsANormalOfLengthOne) {
  const Asset asset = read(truck());
  const GlbFile file = animate(asset, pose_surface(asset), {});
  const Json& primitive = file.mesh_of(2)["primitives"][0];
  for (size_t k = 0; k < primitive["targets"].size(); ++k) {
    std::vector<double> one(primitive["targets"].size(), 0);
    one[k] = 1;
    for (const std::vector<double>& d : file.moved(primitive, "NORMAL", one))
      EXPECT_NEAR(std::hypot(d[0], d[1], 1 + d[2]), 1, 1e-6);
  }
}

TEST_F(GlbClients, ALongClipIsShownInPiecesThatTakeTurns) {
  const Asset asset = read(instances());
  const Surface surface = pose_surface(asset);
  const auto writer =
      AnimationWriter::create(out, asset, surface, {.keyframe = true, .max_targets = 4});
  for (int t = 0; t < kFrames; ++t) writer->frame({.displacement = wave(surface, t)});
  writer->finish();
  ASSERT_EQ(writer->notes().size(), 1u);
  expect_says(writer->notes()[0], "3 pieces");
  const GlbFile file(out);
  // node 1 has handed its mesh to three children, of which the first is there from the start
  const Json& node = file.document["nodes"][1];
  ASSERT_EQ(node["children"].size(), 3u);
  EXPECT_FALSE(node.contains("mesh"));
  for (size_t p = 0; p < 3; ++p) {
    const size_t child = node["children"][p];
    const Json& shown = file.document["nodes"][child];
    EXPECT_EQ(shown["name"], "plain_part_" + std::to_string(p + 1));
    EXPECT_EQ(shown.contains("scale"), p > 0);
    EXPECT_LE(file.mesh_of(child)["primitives"][0]["targets"].size(), 4u);
    for (const Json& channel : file.document["animations"][0]["channels"]) {
      if (channel["target"]["node"] != child || channel["target"]["path"] != "scale") continue;
      const Json& sampler =
          file.document["animations"][0]["samplers"][channel["sampler"].get<size_t>()];
      EXPECT_EQ(sampler["interpolation"], "STEP");
      const Rows scale = file.floats(sampler["output"]);
      for (size_t key = 0; key < 3; ++key)
        EXPECT_EQ(scale[key], std::vector<double>(3, key == p ? 1 : 0));
    }
  }
}

TEST_F(GlbClients, MeshesThatTouchStayTogether) {
  // two triangles of two nodes that share an edge, moved by more than a target can hold
  Builder builder = triangle();
  builder.document["nodes"] = {{{"mesh", 0}},
                               {{"mesh", 0}, {"scale", {1, -1, 1}}},
                               {{"mesh", 0}, {"translation", {0, 0, 50}}}};
  const Asset asset = read(builder);
  const Surface surface = pose_surface(asset);
  const std::vector<std::vector<size_t>> groups = touching_instances(surface);
  EXPECT_EQ(groups, (std::vector<std::vector<size_t>>{{0, 1}, {2}}));
  const GlbFile file = animate(asset, surface, {.modal_error = 0.01});
  EXPECT_EQ(file.weights(0), file.weights(1));
}

TEST_F(GlbClients, CollidersStandAndMoveInTheAssetsNumbers) {
  const Asset asset = read(instances());
  const Surface surface = pose_surface(asset, 0.5);
  // a floor at rest and a ball that moves
  Scene scene;
  scene.colliders = {half_space({0, 1, 0}, -0.25, 0.5), Collider{}};
  Collider& ball = scene.colliders[1];
  ball.name = "ball";
  ball.shape = Collider::Shape::kSphere;
  ball.centre = {0.1, 0.2, 0.3};
  ball.radius = 0.05;
  ball.path = {{0, {}}, {1, {0, 0.4, 0}}};
  const Matrix4 root = root_matrix(surface.scale, {2, 1});
  const auto writer = AnimationWriter::create(
      out, asset, surface, {.fps = 4, .colliders = true, .root = root, .scene = &scene});
  for (int t = 0; t < kFrames; ++t) writer->frame({.displacement = wave(surface, t)});
  writer->finish();
  const GlbFile file(out);
  const Asset again = read_gltf(out);
  std::map<std::string, Box> box;  // as the asset has them, in metres
  for (size_t n = 0; n < again.nodes.size(); ++n) {
    if (again.nodes[n].mesh < 0) continue;
    const Matrix4 world = world_matrix(again, int(n));
    for (const Vec3& p : again.meshes[size_t(again.nodes[n].mesh)].position) {
      Vec3 x;
      for (size_t r = 0; r < 3; ++r)
        x[r] = world[r] * p[0] + world[4 + r] * p[1] + world[8 + r] * p[2] + world[12 + r];
      box[again.nodes[n].name].add({x[0], -x[2], x[1]});  // z was turned up
    }
  }
  EXPECT_NEAR(box["floor"].lower[1], -0.25, 1e-6);
  EXPECT_NEAR(box["floor"].upper[1], -0.25, 1e-6);
  EXPECT_GT(box["floor"].extent(0), surface.box.extent(0));
  for (size_t d = 0; d < 3; ++d) {
    EXPECT_NEAR(box["ball"].lower[d], ball.centre[d] - 0.05, 1e-3);
    EXPECT_NEAR(box["ball"].upper[d], ball.centre[d] + 0.05, 1e-3);
  }
  // only the ball moves
  int moving = 0;
  for (const Json& channel : file.document["animations"][0]["channels"]) {
    if (channel["target"]["path"] != "translation") continue;
    ++moving;
    EXPECT_EQ(file.document["nodes"][channel["target"]["node"].get<size_t>()]["name"], "ball");
    const Json& sampler =
        file.document["animations"][0]["samplers"][channel["sampler"].get<size_t>()];
    const Rows places = file.floats(sampler["output"]);
    EXPECT_NEAR((places[2][1] - places[0][1]) * surface.scale, 0.2, 1e-6);
    EXPECT_NEAR((places[8][1] - places[0][1]) * surface.scale, 0.4, 1e-6);
  }
  EXPECT_EQ(moving, 1);
}

TEST_F(GlbClients, ANodeScaledToZeroIsSaid) {
  Builder builder = triangle();
  builder.document["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {0, 0, 4}}}};
  Asset asset = read(builder);
  asset.format = "fbx";  // glTF nodes without extent are hidden
  asset.nodes[1].matrix[5] = 0;
  const Surface surface = pose_surface(asset);
  const auto writer = AnimationWriter::create(out, asset, surface, {});
  for (int t = 0; t < kFrames; ++t) writer->frame({.displacement = wave(surface, t)});
  writer->finish();
  ASSERT_EQ(writer->warnings().size(), 1u);
  expect_says(writer->warnings()[0], "scaled to zero");
}

}  // namespace
}  // namespace elastogen
