// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_hidden.hpp"

#include "tests/io/glb_clip.hpp"

namespace elastogen {
namespace {

using test::Builder, test::error_of, test::expect_says, test::GlbFile, test::Json, test::triangle;
using GltfHidden = test::GlbClip;

const Json kInvisible = {{"KHR_node_visibility", {{"visible", false}}}};

/// Nodes with the mesh: a shown one; hidden, below hidden, flat, at a point, below a flat one.
Builder hidden() {
  Builder builder = triangle();
  builder.document["extensionsUsed"] = builder.document["extensionsRequired"] =
      Json::array({"KHR_node_visibility"});
  builder.document["nodes"] = {
      {{"name", "shown"}, {"mesh", 0}, {"scale", {1, 1, -2}}},
      {{"name", "off"}, {"children", {2}}, {"extensions", kInvisible}},
      {{"name", "below"},
       {"mesh", 0},
       {"translation", {0, 0, 9}},
       {"extensions", {{"KHR_node_visibility", {{"visible", true}}}}}},
      {{"name", "flat"}, {"mesh", 0}, {"scale", {5, 0, 5}}, {"children", {5}}},
      {{"name", "point"},
       {"mesh", 0},
       {"matrix", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 7, 7, 1}}},
      {{"name", "under"}, {"mesh", 0}},
      {{"name", "lamp"}, {"extensions", kInvisible}}};
  return builder;
}

TEST_F(GltfHidden, NodesAreNotSimulatedAndDoNotCountForTheSize) {
  const Asset asset = read(hidden());
  ASSERT_EQ(asset.findings.size(), 1u);
  EXPECT_EQ(asset.findings[0].what, "hidden");
  EXPECT_EQ(asset.findings[0].count, 4);
  EXPECT_EQ(asset.findings[0].text, "nodes with a mesh are hidden: below, flat, point, under");
  EXPECT_EQ(kind_of(asset.findings[0]).severity, Severity::kNote);
  const Surface surface = pose_surface(asset);
  ASSERT_EQ(surface.instances.size(), 1u);
  EXPECT_EQ(surface.instances[0].node, 0);
  EXPECT_EQ(surface.box.upper[0], 1);
  EXPECT_EQ(surface.box.upper[2], 0);
}

TEST_F(GltfHidden, TheOutputKeepsThemAsTheyWere) {
  Builder builder = hidden();
  builder.document["meshes"][0]["extras"] = {{"targetNames", {"smile"}}};
  builder.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 1}}};
  const Asset asset = read(builder);
  const GlbFile file = animate(asset, pose_surface(asset), {});
  for (size_t n = 1; n < 7; ++n)
    EXPECT_EQ(file.document["nodes"][n], builder.document["nodes"][n]) << n;
  EXPECT_EQ(file.document["meshes"][0], builder.document["meshes"][0]);
  EXPECT_EQ(file.document["extensionsUsed"], builder.document["extensionsUsed"]);
  EXPECT_EQ(file.document["extensionsRequired"], builder.document["extensionsRequired"]);
  // the shown one moves with a mesh of its own
  const Json& mesh = file.mesh_of(0);
  EXPECT_NE(file.document["nodes"][0]["mesh"], 0);
  EXPECT_GT(mesh["weights"].size(), 0u);
  EXPECT_EQ(mesh["extras"]["targetNames"].size(), mesh["weights"].size());
  EXPECT_EQ(mesh["primitives"][0]["targets"].size(), mesh["weights"].size());
}

TEST_F(GltfHidden, ASkinnedMeshIsHiddenByVisibilityButNotByTheScaleOfItsNode) {
  for (const bool visible : {true, false}) {
    Builder builder = triangle();
    builder.document["nodes"] = {{{"name", "body"}, {"mesh", 0}, {"skin", 0}, {"scale", {0, 0, 0}}},
                                 {{"name", "joint"}, {"translation", {1, 0, 0}}},
                                 {{"name", "other"}, {"mesh", 0}, {"translation", {0, 0, 4}}}};
    if (!visible) builder.document["nodes"][0]["extensions"] = kInvisible;
    builder.document["skins"] = {{{"joints", {1}}}};
    Json& attributes = builder.document["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = builder.add<uint8_t>(std::vector<uint8_t>(12, 0), "VEC4", 5121, 3);
    attributes["WEIGHTS_0"] =
        builder.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 5126, 3);
    const Asset asset = read(builder);
    EXPECT_EQ(pose_surface(asset).instances.size(), visible ? 2u : 1u);
    EXPECT_EQ(asset.findings.back().what, visible ? "skins" : "hidden");
  }
}

TEST_F(GltfHidden, NothingShownIsRefused) {
  Builder builder = triangle();
  builder.document["nodes"][0]["scale"] = {1e-12, 1, 1};
  expect_says(error_of([&] { read(builder); }), "no triangle that is shown");
  builder.document["nodes"][0]["scale"] = {1e-12, 1e-12, 1e-12};  // small, not flat
  EXPECT_EQ(read(builder).meshes.size(), 1u);
  builder.document["nodes"][0]["extensions"] = kInvisible;
  expect_says(error_of([&] { read(builder); }), "no triangle that is shown");
}

TEST_F(GltfHidden, RefusesVisibilityThatIsNoTruthValue) {
  Builder builder = triangle();
  for (const Json& wrong : {Json(0), Json("false"), Json(nullptr), Json::array()}) {
    builder.document["nodes"][0]["extensions"] = {{"KHR_node_visibility", {{"visible", wrong}}}};
    expect_says(error_of([&] { read(builder); }), "nodes[0]: \"visible\" must be true or false");
  }
  builder.document["nodes"][0]["extensions"] = {{"KHR_node_visibility", 1}};
  expect_says(error_of([&] { read(builder); }), "nodes[0]: KHR_node_visibility must be an object");
}

TEST(GltfHiddenNames, AreShortened) {
  std::vector<AssetNode> nodes(12);
  std::vector<int> all;
  for (int n = 0; n < 12; ++n) all.push_back(n);
  nodes[1].name = "b\n";
  EXPECT_EQ(node_names(nodes, {0, 1}), "nodes[0], b ");
  EXPECT_NE(node_names(nodes, all).find("nodes[7] and 4 more"), std::string::npos);
}

}  // namespace
}  // namespace elastogen
