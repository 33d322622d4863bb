// SPDX-License-Identifier: Apache-2.0
#include "voxelize/demo_character.hpp"

#include "core/parallel.hpp"
#include "io/weld.hpp"
#include "tests/voxelize/shapes.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

TEST(DemoCharacter, IsAClosedFigureOneMetreTallOnTheGround) {
  const Asset asset = demo_character();
  const Surface surface = pose_surface(asset);
  const WeldedMesh mesh = weld(surface);
  EXPECT_TRUE(mesh.closed());
  EXPECT_EQ(mesh.pieces, 1);
  EXPECT_EQ(mesh.turned_edges, 0);
  EXPECT_GT(mesh.volume, 0.05);
  EXPECT_NEAR(surface.box.lower[1], 0, 1e-12);
  EXPECT_NEAR(surface.box.upper[1], 1, 1e-12);
  EXPECT_GT(surface.triangles.rows(), 5000);
  EXPECT_LT(surface.triangles.rows(), 15000);
}

TEST(DemoCharacter, EveryDrawnVertexHasUvColourAndAUnitNormal) {
  const Mesh mesh = demo_character().meshes.at(0);
  const size_t drawn = mesh.position_of.size();
  ASSERT_EQ(mesh.uv.size(), drawn);
  ASSERT_EQ(mesh.normal.size(), drawn);
  ASSERT_EQ(mesh.colour.size(), drawn);
  for (size_t v = 0; v < mesh.position.size(); ++v)
    ASSERT_EQ(mesh.position_of[v], static_cast<int32_t>(v));
  for (const auto& [x, y, z] : mesh.normal) ASSERT_NEAR(x * x + y * y + z * z, 1, 1e-5);
  // no triangle is stretched over the seam
  for (const TriangleGroup& group : mesh.groups)
    for (size_t i = 0; i < group.corner.size(); i += 3)
      for (int k = 0; k < 3; ++k)
        ASSERT_LE(
            std::abs(mesh.uv[group.corner[i + k]][0] - mesh.uv[group.corner[i + (k + 1) % 3]][0]),
            0.51f);
}

TEST(DemoCharacter, HasTwoMaterialsOnTheSurfaceAndInTheGrid) {
  const Asset asset = demo_character();
  ASSERT_EQ(asset.materials.size(), 2u);
  for (const TriangleGroup& group : asset.meshes[0].groups) EXPECT_GT(group.corner.size(), 300u);
  const VoxelGrid grid = voxelize(pose_surface(asset), {.voxels = 32}).grid;
  EXPECT_EQ(grid.pieces, 1);
  const Array<int32_t> region = demo_regions(grid);
  int64_t head = 0;
  for (int64_t v = 0; v < region.rows(); ++v) {
    ASSERT_TRUE(region(v) == 0 || region(v) == 1);
    head += region(v);
  }
  EXPECT_GT(head, grid.voxel_count() / 4);
  EXPECT_LT(head, grid.voxel_count() * 3 / 4);
}

TEST(DemoCharacter, IsTheSameToTheBitOnAnyThreads) {
  std::vector<Mesh> mesh;
  for (const int threads : {1, 2}) {
    const ThreadLimit control(threads);
    mesh.push_back(demo_character().meshes.at(0));
  }
  EXPECT_EQ(mesh[0].position, mesh[1].position);
  EXPECT_EQ(mesh[0].uv, mesh[1].uv);
  EXPECT_EQ(mesh[0].groups[0].corner, mesh[1].groups[0].corner);
  EXPECT_EQ(mesh[0].groups[1].corner, mesh[1].groups[1].corner);
}

}  // namespace
}  // namespace elastogen
