// SPDX-License-Identifier: Apache-2.0
#include "io/animation_writer.hpp"
#include "tests/io/glb_clip.hpp"

#include <cmath>
#include <numbers>
#include <set>

namespace elastogen {
namespace {

using test::Builder, test::expect_says, test::GlbFile, test::instances, test::Json, test::kFrames;
using test::Rows, test::shown_by, test::triangle, test::wave;
using GlbWriter = test::GlbClip;

TEST_F(GlbWriter, ShowsTheDisplacementsInTheWorld) {
  const Asset asset = read(instances());
  for (const double size : {0.0, 0.05}) {
    const Surface surface = pose_surface(asset, size);
    const double edge = surface.box.extent(2) > surface.box.extent(1) ? surface.box.extent(2)
                                                                      : surface.box.extent(1);
    const GlbFile exact = animate(asset, surface, {.keyframe = true});
    EXPECT_LT(shown_error(exact, asset, surface), 1e-6 * edge);
    const GlbFile modal = animate(asset, surface, {.modal_error = 1e-3});
    const Json& record = modal.document["asset"]["extras"]["elastogen"];
    const double error = shown_error(modal, asset, surface);
    EXPECT_NEAR(error, record["max_error_m"].get<double>(), 1e-6 * edge);
    EXPECT_LE(error, 1.001e-3 * std::max({surface.box.extent(0), surface.box.extent(1),
                                          surface.box.extent(2)}));
    EXPECT_GE(record["targets"], 1);
    EXPECT_LT(record["targets"], kFrames);
  }
}

TEST_F(GlbWriter, GivesEachInstanceAMeshOfItsOwnWithSharedVertices) {
  const Asset asset = read(instances());
  const GlbFile file = animate(asset, pose_surface(asset), {});
  std::set<size_t> meshes;
  for (const int node : {1, 2, 3}) {
    const size_t shown = shown_by(file, node);
    meshes.insert(file.document["nodes"][shown]["mesh"].get<size_t>());
    EXPECT_EQ(file.mesh_of(shown)["primitives"][0]["attributes"]["TEXCOORD_0"], 2);
    EXPECT_EQ(file.mesh_of(shown)["weights"], file.document["nodes"][shown]["weights"]);
  }
  EXPECT_EQ(meshes.size(), 3u);
  EXPECT_EQ(file.document["animations"][0]["channels"].size(), 3u);
}

TEST_F(GlbWriter, AnimatesNoNodeWithAMatrix) {
  const Asset asset = read(instances());
  const GlbFile file = animate(asset, pose_surface(asset), {.keyframe = true});
  for (const Json& channel : file.document["animations"][0]["channels"]) {
    const size_t node = channel["target"]["node"];
    EXPECT_FALSE(file.document["nodes"][node].contains("matrix"));
    EXPECT_TRUE(file.document["nodes"][node].contains("mesh"));
  }
  EXPECT_EQ(file.document["nodes"][3]["name"], "sheared");
  EXPECT_TRUE(file.document["nodes"][3].contains("matrix"));
}

TEST_F(GlbWriter, TheRestFrameIsTheAssetItself) {
  const Asset asset = read(instances());
  for (const bool keyframe : {false, true}) {
    const GlbFile file = animate(asset, pose_surface(asset), {.keyframe = keyframe});
    const Rows weights = file.weights(1);
    for (const double weight : weights[0]) EXPECT_EQ(weight, 0);
    const Asset again = read_gltf(out);
    EXPECT_EQ(again.meshes[0].position, asset.meshes[0].position);
    EXPECT_EQ(again.meshes[0].uv, asset.meshes[0].uv);
  }
}

TEST_F(GlbWriter, KeepsTheBytesOfTheSource) {
  const std::string assets = test::assets_folder();
  std::vector<std::string> paths = {folder.write("source.glb", instances().file())};
  if (!assets.empty()) {
    for (const char* name :
         {"generators/trellis_sample.glb", "gltf/CesiumMilkTruck.glb", "gltf/spot_nodes.glb"})
      paths.push_back(assets + name);
  }
  for (const std::string& path : paths) {
    const Asset asset = read_gltf(path);
    const Surface surface = pose_surface(asset);
    const GlbFile before(path), after = animate(asset, surface, {});
    Json materials = before.document.value("materials", Json::array());
    // a triangle with normals and without a material gets the one that glTF means
    if (path == paths[0]) materials.push_back(Json::object());
    EXPECT_EQ(materials, after.document.value("materials", Json::array())) << path;
    for (const char* list : {"textures", "images", "samplers", "cameras"})
      EXPECT_EQ(before.document.value(list, Json()), after.document.value(list, Json())) << path;
    for (size_t i = 0; i < before.document["accessors"].size(); ++i)
      EXPECT_EQ(before.document["accessors"][i], after.document["accessors"][i]) << path;
    for (size_t i = 0; i < before.document["bufferViews"].size(); ++i)
      EXPECT_EQ(before.view_bytes(i), after.view_bytes(i)) << path << " view " << i;
    for (size_t i = 0; i < before.document["nodes"].size(); ++i) {
      for (const char* key : {"name", "matrix", "translation", "rotation", "scale"})
        EXPECT_EQ(before.document["nodes"][i].value(key, Json()),
                  after.document["nodes"][i].value(key, Json()));
    }
    const double edge =
        std::max({surface.box.extent(0), surface.box.extent(1), surface.box.extent(2)});
    EXPECT_LE(shown_error(after, asset, surface), 1.001e-3 * edge) << path;
    const Asset again = read_gltf(out);
    EXPECT_EQ(pose_surface(again).triangles.rows(), surface.triangles.rows()) << path;
  }
}

TEST_F(GlbWriter, EmbedsFilesFromBeside) {
  Builder builder = triangle();
  const std::string image = "\x89PNG\r\n\x1a\n and so on";
  folder.write("b.bin", builder.bin);
  folder.write("t.png", image);
  Json document = builder.document;
  document["buffers"] = {{{"byteLength", builder.bin.size()}, {"uri", "b.bin"}}};
  document["images"] = {{{"uri", "t.png"}}, {{"uri", "lost.png"}}};
  const Asset asset = read_gltf(folder.write("a.gltf", document.dump()));
  const GlbFile file = animate(asset, pose_surface(asset), {});
  EXPECT_EQ(file.document["buffers"].size(), 1u);
  EXPECT_FALSE(file.document["buffers"][0].contains("uri"));
  const Json& embedded = file.document["images"][0];
  EXPECT_EQ(embedded["mimeType"], "image/png");
  EXPECT_EQ(file.view_bytes(embedded["bufferView"]), image);
  EXPECT_EQ(file.view_bytes(file.document["images"][1]["bufferView"]).substr(0, 4), "\x89PNG");
  expect_says(file.document["asset"]["extras"]["elastogen"]["notes"][0], "lost.png");
}

TEST_F(GlbWriter, ReplacesAnimationsAndMorphTargetsOfTheSource) {
  Builder builder = triangle();
  builder.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 1}}};
  builder.document["meshes"][0]["weights"] = {1};
  builder.document["nodes"][0]["weights"] = {1};
  builder.document["animations"] = {{{"channels", Json::array()}, {"samplers", Json::array()}}};
  const Asset asset = read(builder);
  const Surface surface = pose_surface(asset);
  const GlbFile file = animate(asset, surface, {.keyframe = true});
  EXPECT_EQ(file.document["animations"].size(), 1u);
  EXPECT_EQ(file.mesh_of(0)["primitives"][0]["targets"].size(), size_t(kFrames - 1));
  EXPECT_LT(shown_error(file, asset, surface), 1e-6);
}

TEST_F(GlbWriter, LinesBesideTrianglesRideAlong) {
  // lines before the triangles, a strip behind them, and points of the triangle's own vertices
  Builder builder = triangle();
  const int other = builder.add_vectors({0, 0, 0, 1, 1, 1}), third = builder.add_vectors({2, 0, 0});
  Json& primitives = builder.document["meshes"][0]["primitives"];
  primitives.insert(primitives.begin(), Json{{"attributes", {{"POSITION", other}}}, {"mode", 1}});
  builder.add_primitive({{"attributes", {{"POSITION", third}}}, {"mode", 3}});
  builder.add_primitive({{"attributes", {{"POSITION", 0}}}, {"mode", 0}});
  const Asset asset = read(builder);
  EXPECT_EQ(asset.meshes[0].position,
            (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 1, 1}, {2, 0, 0}}));
  const Surface surface = pose_surface(asset);
  EXPECT_EQ(surface.box.upper[0], 1);  // they do not bound the body
  const GlbFile file = animate(asset, surface, {.keyframe = true});
  const Array<double> expected = wave(surface, 5);
  const std::vector<double> weight = file.weights(0)[5];
  const std::vector<std::vector<int64_t>> vertices = {{3, 4}, {0, 1, 2}, {5}, {0, 1, 2}};
  for (size_t p = 0; p < vertices.size(); ++p) {
    const Rows d = file.moved(file.mesh_of(0)["primitives"][p], "POSITION", weight);
    ASSERT_EQ(d.size(), vertices[p].size());
    for (size_t v = 0; v < d.size(); ++v)
      for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(d[v][c], expected(vertices[p][v], int(c)), 1e-6) << p;
  }
}

TEST_F(GlbWriter, AFileOfLinesAloneIsRefused) {
  Builder builder = triangle();
  builder.document["meshes"][0]["primitives"][0]["mode"] = 3;
  const Asset asset = read(builder);
  expect_says(test::error_of([&] { pose_surface(asset); }), "no triangle");
}

TEST_F(GlbWriter, MovedPrimitivesHaveNoTangents) {
  Builder builder = triangle();
  builder.document["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] =
      builder.add<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, "VEC4", 5126, 3);
  builder.document["nodes"].push_back(
      {{"name", "off"},
       {"mesh", 0},
       {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  const Asset asset = read(builder);
  EXPECT_EQ(asset.findings.back().what, "tangents");
  EXPECT_EQ(asset.findings.back().count, 1);
  const GlbFile file = animate(asset, pose_surface(asset), {});
  EXPECT_FALSE(file.mesh_of(0)["primitives"][0]["attributes"].contains("TANGENT"));
  EXPECT_TRUE(file.mesh_of(1)["primitives"][0]["attributes"].contains("TANGENT"));
}

TEST_F(GlbWriter, TurnsNormalsWithTheBody) {
  // normals that are not the triangle's own, turned by 40 degrees about a skew axis
  Builder builder = triangle();
  const std::vector<float> normals = {0.6f, 0, 0.8f, 0, 1, 0, 0, 0.28f, 0.96f};
  builder.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      builder.add_vectors(normals);
  const Asset asset = read(builder);
  const Surface surface = pose_surface(asset);
  const double c = std::cos(40 * std::numbers::pi / 180), s = std::sin(40 * std::numbers::pi / 180);
  const double a[3] = {2.0 / 3, -1.0 / 3, 2.0 / 3};
  const auto turned = [&](const double* x, int r) {
    const int i = (r + 1) % 3, j = (r + 2) % 3;
    const double along = a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
    return c * x[r] + s * (a[i] * x[j] - a[j] * x[i]) + (1 - c) * along * a[r];
  };
  Array<double> d(3, 3);
  for (int v = 0; v < 3; ++v) {
    for (int r = 0; r < 3; ++r)
      d(v, r) = turned(surface.vertices.row(v), r) - surface.vertices(v, r);
  }
  for (const bool keyframe : {true, false}) {
    const auto writer = AnimationWriter::create(out, asset, surface, {.keyframe = keyframe});
    writer->frame({.displacement = Array<double>(3, 3)});
    writer->frame({.displacement = d});
    writer->finish();
    const GlbFile file(out);
    const Rows delta = file.moved(file.mesh_of(0)["primitives"][0], "NORMAL", file.weights(0)[1]);
    for (size_t v = 0; v < 3; ++v) {
      const double n[3] = {normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]};
      for (int r = 0; r < 3; ++r) EXPECT_NEAR(delta[v][size_t(r)], turned(n, r) - n[r], 1e-6);
    }
  }
}

TEST_F(GlbWriter, StatesBoundsAndTimes) {
  const Asset asset = read(instances());
  const GlbFile file = animate(asset, pose_surface(asset), {.fps = 24});
  // bounds of every target
  for (const Json& mesh : file.document["meshes"]) {
    for (const Json& primitive : mesh["primitives"]) {
      for (const Json& target : primitive["targets"]) {
        const size_t index = target["POSITION"];
        const Rows rows = file.floats(index);
        for (size_t d = 0; d < 3; ++d) {
          double lower = INFINITY, upper = -INFINITY;
          for (const auto& row : rows) {
            lower = std::min(lower, row[d]);
            upper = std::max(upper, row[d]);
          }
          EXPECT_EQ(file.document["accessors"][index]["min"][d], lower);
          EXPECT_EQ(file.document["accessors"][index]["max"][d], upper);
        }
      }
    }
  }
  // times of the frames
  const size_t input = file.document["animations"][0]["samplers"][0]["input"];
  const Rows times = file.floats(input);
  for (int t = 0; t < kFrames; ++t) EXPECT_EQ(times[size_t(t)][0], double(float(t / 24.0)));
  EXPECT_EQ(file.document["accessors"][input]["min"], Json::array({0.0}));
  EXPECT_EQ(file.document["accessors"][input]["max"], Json::array({times.back()[0]}));
}

TEST_F(GlbWriter, CarriesTheCertificateOfEachFrame) {
  const Asset asset = read(triangle());
  const AnimationOptions options{
      .fps = 25, .generator = "elastogen 1", .command = "run \xff", .commit = "abc"};
  const Json record =
      animate(asset, pose_surface(asset), options).document["asset"]["extras"]["elastogen"];
  EXPECT_EQ(record["fps"], 25);
  EXPECT_EQ(record["commit"], "abc");
  EXPECT_EQ(record["profile"], "modal");
  ASSERT_EQ(record["frames"].size(), size_t(kFrames));
  EXPECT_EQ(record["frames"][3]["converged"], false);
  EXPECT_EQ(record["frames"][4]["converged"], true);
  EXPECT_EQ(record["frames"][4]["residual"], 1e-4 * 4);
  EXPECT_EQ(record["frames"][4]["min_j"], 1 - 0.01 * 4);
}

TEST_F(GlbWriter, PutsTheRootAboveTheScene) {
  const Asset asset = read(instances());
  const Matrix4 root = {0.5, 0, 0, 0, 0, 0, -0.5, 0, 0, 0.5, 0, 0, 1, 2, 3, 1};
  animate(asset, pose_surface(asset), {.root = root});
  const Asset again = read_gltf(out);
  const Surface before = pose_surface(asset), after = pose_surface(again);
  ASSERT_EQ(after.vertices.rows(), before.vertices.rows());
  for (int64_t v = 0; v < 14; ++v) {  // the first two instances keep their nodes and their order
    const double* x = before.vertices.row(v);
    EXPECT_NEAR(after.vertices(v, 0), 0.5 * x[0] + 1, 1e-12);
    EXPECT_NEAR(after.vertices(v, 1), 0.5 * x[2] + 2, 1e-12);
    EXPECT_NEAR(after.vertices(v, 2), -0.5 * x[1] + 3, 1e-12);
  }
}

/// A square of two materials with a seam: drawn vertex 4 splits position 1.
Asset plain_asset(const Vec3& centre) {
  Asset asset;
  asset.format = "obj";
  asset.path = "square.obj";
  Mesh mesh;
  mesh.name = "square";
  for (const Vec3& p : {Vec3{-1, -1, 0}, Vec3{1, -1, 0.1}, Vec3{1, 1, 0}, Vec3{-1, 1, 0.3}})
    mesh.position.push_back({p[0] + centre[0], p[1] + centre[1], p[2] + centre[2]});
  mesh.position_of = {0, 1, 2, 3, 1};
  mesh.uv = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5f, 0}};
  mesh.colour.assign(5, {1, 0.5f, 0.25f, 1});
  mesh.groups = {{0, {0, 1, 2}, -1}, {1, {}, -1}, {-1, {0, 2, 3, 4, 2, 0}, -1}};
  asset.meshes = {mesh};
  asset.nodes = {{"node", -1, kIdentity4, 0}};
  asset.materials = {{"red", {1, 0, 0, 1}, "", false}, {"unused", {0, 1, 0, 0.5f}, "", true}};
  return asset;
}

TEST_F(GlbWriter, MakesADocumentOfOtherFormats) {
  Asset asset = plain_asset({});
  const std::string image = "\xff\xd8\xff and so on";
  asset.materials[0].texture = folder.write("t.jpg", image);
  asset.materials[1].texture = folder.write("t.tga", "no picture");
  const Surface surface = pose_surface(asset);
  const GlbFile file = animate(asset, surface, {.keyframe = true});
  const Asset again = read_gltf(out);
  ASSERT_EQ(again.meshes.size(), 1u);
  const Mesh& mesh = again.meshes[0];
  EXPECT_EQ(mesh.name, "square");
  EXPECT_EQ(again.nodes[0].name, "node");
  ASSERT_EQ(mesh.position.size(), 5u);
  for (size_t v = 0; v < 5; ++v) {
    const Vec3& p = asset.meshes[0].position[size_t(asset.meshes[0].position_of[v])];
    for (size_t d = 0; d < 3; ++d) EXPECT_EQ(mesh.position[v][d], double(float(p[d])));
  }
  EXPECT_EQ(mesh.uv, asset.meshes[0].uv);
  EXPECT_EQ(mesh.colour, asset.meshes[0].colour);
  ASSERT_EQ(mesh.groups.size(), 2u);
  EXPECT_EQ(mesh.groups[1].corner, asset.meshes[0].groups[2].corner);
  EXPECT_EQ(again.materials[0].base_colour, asset.materials[0].base_colour);
  EXPECT_TRUE(again.materials[1].double_sided);
  const size_t view = file.document["images"][0]["bufferView"];
  EXPECT_EQ(file.view_bytes(view), image);
  expect_says(file.document["asset"]["extras"]["elastogen"]["notes"][0], "t.tga");

  // drawn vertices move with their positions
  for (int t = 0; t < kFrames; ++t) {
    const Array<double> expected = wave(surface, t);
    const Rows d =
        file.moved(file.mesh_of(0)["primitives"][1], "POSITION", file.weights(0)[size_t(t)]);
    for (size_t v = 0; v < 5; ++v) {
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(d[v][size_t(c)], expected(asset.meshes[0].position_of[v], c), 1e-7);
    }
  }
}

TEST_F(GlbWriter, KeepsTheShapeOfWhatLiesFarAway) {
  const Vec3 centre = {1e7, -2e7, 5e6};
  const Asset asset = plain_asset(centre);
  animate(asset, pose_surface(asset), {});
  const Asset again = read_gltf(out);
  for (size_t v = 0; v < 5; ++v) {
    const Vec3& p = asset.meshes[0].position[size_t(asset.meshes[0].position_of[v])];
    for (size_t d = 0; d < 3; ++d) {
      const double at = again.meshes[0].position[v][d] + again.nodes[0].matrix[12 + d];
      EXPECT_NEAR(at, p[d], 1e-7 + 4e-9);  // float32 of the local number, double of the whole
    }
  }
}

}  // namespace
}  // namespace elastogen
