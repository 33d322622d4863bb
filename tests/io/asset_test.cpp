// SPDX-License-Identifier: Apache-2.0
#include "io/asset.hpp"

#include "io/weld.hpp"
#include "tests/io/test_files.hpp"

#include <cmath>
#include <limits>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

Matrix4 translation(double x, double y, double z) {
  return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1};
}

Matrix4 scaling(double x, double y, double z) {
  return {x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1};
}

/// A quarter turn about z: x to y, y to -x.
constexpr Matrix4 kTurn = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/// Tetrahedron (0, e_x, e_y, e_z) of volume 1/6, outside out, in two materials, and no node.
Asset tetrahedron() {
  Asset asset;
  asset.path = "tetrahedron";
  asset.materials.resize(2);
  Mesh& mesh = asset.meshes.emplace_back();
  mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.position_of = {0, 1, 2, 3, 3};  // a seam at the tip
  mesh.groups = {{0, {0, 2, 1, 0, 1, 3}, -1}, {1, {0, 4, 2, 1, 2, 4}, -1}};
  return asset;
}

void expect_near(const Vec3& a, const Vec3& b) {
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(a[d], b[d], 1e-15);
}

Vec3 vertex(const Surface& s, int64_t i) {
  return {s.vertices(i, 0), s.vertices(i, 1), s.vertices(i, 2)};
}

TEST(Asset, NodesPoseTheirChildren) {
  Asset asset = tetrahedron();
  // the child stands before its parent in the file
  asset.nodes = {{"child", 1, translation(1, 0, 0), 0}, {"root", -1, kTurn, -1}};
  const Matrix4 world = world_matrix(asset, 0);
  expect_near({world[12], world[13], world[14]}, {0, 1, 0});
  const Surface surface = pose_surface(asset);
  ASSERT_EQ(surface.vertices.rows(), 4);
  expect_near(vertex(surface, 1), {0, 2, 0});
  expect_near(vertex(surface, 2), {-1, 1, 0});
}

TEST(Asset, InstancesStandOneBehindTheOther) {
  Asset asset = tetrahedron();
  asset.nodes = {
      {"a", -1, kIdentity4, 0}, {"empty", -1, kIdentity4, -1}, {"b", 1, translation(5, 0, 0), 0}};
  const Surface surface = pose_surface(asset);
  ASSERT_EQ(surface.instances.size(), 2u);
  EXPECT_EQ(surface.instances[1].node, 2);
  EXPECT_EQ(surface.instances[1].first_vertex, 4);
  EXPECT_EQ(surface.instances[1].first_triangle, 4);
  EXPECT_EQ(surface.instances[1].triangles, 4);
  EXPECT_EQ(surface.triangles.rows(), 8);
  EXPECT_EQ(surface.triangles(6, 1), 4 + 3);  // the seam's vertex is its position
  EXPECT_EQ(surface.material(1), 0);
  EXPECT_EQ(surface.material(6), 1);
  EXPECT_NEAR(weld(surface).volume, 2. / 6, 1e-15);
}

TEST(Asset, MirroredInstancesKeepTheirOutsideOutside) {
  Asset asset = tetrahedron();
  asset.nodes = {{"mirrored", -1, scaling(-2, 1, 1), 0}};
  const WeldedMesh w = weld(pose_surface(asset));
  EXPECT_TRUE(w.closed() && w.balanced());
  EXPECT_NEAR(w.volume, 2. / 6, 1e-15);
}

TEST(Asset, TheIdentityKeepsEveryBit) {
  Asset asset = tetrahedron();
  asset.meshes[0].position[1] = {0.1, -0.0, 1e-300};
  asset.nodes = {{"a", -1, kIdentity4, 0}};
  const Surface surface = pose_surface(asset);
  EXPECT_EQ(vertex(surface, 1), asset.meshes[0].position[1]);
  EXPECT_TRUE(std::signbit(surface.vertices(1, 1)));
}

TEST(Asset, SizeIsTheLongestEdgeOfWhatTrianglesUse) {
  Asset asset = tetrahedron();
  asset.meshes[0].position[2][1] = 4;
  asset.meshes[0].position.push_back({1000, 0, 0});  // used by no triangle
  asset.nodes = {{"a", -1, kIdentity4, 0}};
  EXPECT_EQ(pose_surface(asset).scale, 1);
  const Surface surface = pose_surface(asset, 0.5);
  EXPECT_DOUBLE_EQ(surface.scale, 0.125);
  EXPECT_DOUBLE_EQ(surface.box.extent(1), 0.5);
  EXPECT_DOUBLE_EQ(surface.box.extent(0), 0.125);
  EXPECT_DOUBLE_EQ(surface.vertices(4, 0), 125);
}

TEST(Asset, RefusesBadTrees) {
  Asset asset = tetrahedron();
  asset.nodes = {{"a", 1, kIdentity4, 0}, {"b", 0, kIdentity4, -1}};
  expect_says(error_of([&] { world_matrix(asset, 0); }), "node 0 (a) is its own ancestor");
  expect_says(error_of([&] { pose_surface(asset); }), "is its own ancestor");
  asset.nodes = {{"a", 0, kIdentity4, 0}};
  expect_says(error_of([&] { pose_surface(asset); }), "is its own ancestor");
  asset.nodes = {{"a", 7, kIdentity4, 0}};
  expect_says(error_of([&] { pose_surface(asset); }), "node 0 has the parent 7");
  asset.nodes = {{"a", -1, kIdentity4, 3}};
  expect_says(error_of([&] { pose_surface(asset); }), "node 0 shows the mesh 3 of 1");
  asset.nodes = {{"a", -1, scaling(1e308, 1, 1), 0}};
  asset.meshes[0].position[1][0] = 1e10;
  EXPECT_FALSE(error_of([&] { pose_surface(asset); }).empty());
  asset.nodes = {{"a", -1, scaling(std::nan(""), 1, 1), 0}};
  EXPECT_FALSE(error_of([&] { pose_surface(asset); }).empty());
  error_of([&] { pose_surface(tetrahedron(), -1); }, ErrorKind::kUsage);
  error_of([&] { world_matrix(asset, 1); }, ErrorKind::kUsage);
}

TEST(Asset, ALongChainOfNodesIsPosedInLinearTime) {
  Asset asset = tetrahedron();
  const int n = 100'000;
  for (int k = 0; k < n; ++k)
    asset.nodes.push_back({"", k + 1 < n ? k + 1 : -1, translation(1, 0, 0), -1});
  asset.nodes[0].mesh = asset.nodes[size_t(n / 2)].mesh = 0;
  const Surface surface = pose_surface(asset);
  EXPECT_DOUBLE_EQ(surface.vertices(0, 0), n);
  EXPECT_DOUBLE_EQ(surface.vertices(4, 0), n / 2);
}

TEST(Asset, TooManyInstancesAreRefusedBeforeTheyAreMade) {
  Asset asset = tetrahedron();
  asset.meshes[0].position.resize(1 << 20);
  asset.nodes.assign(1 << 12, {"a", -1, kIdentity4, 0});
  expect_says(error_of([&] { pose_surface(asset); }, ErrorKind::kResources), "more than");
}

TEST(Asset, ABodyFarFromTheOriginIsTakenToItsMiddleWithoutRounding) {
  for (const double edge : {1.0 / 1024, 1.0, 4096.0})
    for (const double far : {1.0, 200.0, -3e5}) {
      Surface surface;
      surface.vertices = Array<double>(2, 3);
      for (int d = 0; d < 3; ++d) {
        surface.vertices(0, d) = edge * far;
        surface.vertices(1, d) = edge * (far + 0.75);
      }
      for (int v = 0; v < 2; ++v)
        surface.box.add({surface.vertices(v, 0), surface.vertices(v, 1), surface.vertices(v, 2)});
      settle(surface);
      EXPECT_EQ(surface.box.origin[0] != 0, far != 1.0);
      EXPECT_EQ(surface.vertices(0, 1) + surface.box.origin[1], edge * far);
      EXPECT_EQ(surface.vertices(1, 2) - surface.vertices(0, 2), edge * 0.75);
      EXPECT_LE(std::abs(surface.box.upper[0]), far == 1.0 ? 2 * edge : edge);
    }
}

}  // namespace
}  // namespace elastogen
