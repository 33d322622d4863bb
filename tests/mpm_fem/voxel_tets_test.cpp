// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/voxel_tets.hpp"

#include "mpm_fem/fem/extrude.hpp"
#include "tests/io/test_files.hpp"
#include "tests/io/tets/tet_checks.hpp"
#include "voxelize/bricks.hpp"

#include <cmath>

namespace elastogen::fem {
namespace {

using test::edge_count, test::error_of, test::expect_says, test::faces, test::tet_determinant,
    test::determinants;

constexpr VoxelSplit kBoth[] = {VoxelSplit::kFive, VoxelSplit::kSix};

/// Scene of voxels with the material 0 or 1 by turns, only as far as meshes need it.
Scene scene_of(VoxelGrid grid) {
  Scene scene;
  scene.grid = std::move(grid);
  scene.materials = {Material{}, Material{}};
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  for (int64_t v = 0; v < scene.material.rows(); ++v) scene.material(v) = int32_t(v % 2);
  return scene;
}

/// A block of voxels that reaches to negative coordinates, with a hole and a handle.
VoxelGrid ragged_grid() {
  std::vector<int32_t> kept;
  for (int32_t k = -2; k < 2; ++k)
    for (int32_t j = -1; j < 2; ++j)
      for (int32_t i = -3; i < 2; ++i)
        if ((j != 0 || i == -3 || i == 1) && (k < 1 || i != 0)) kept.insert(kept.end(), {i, j, k});
  Array<int32_t> coords(int64_t(kept.size() / 3), 3);
  std::copy(kept.begin(), kept.end(), coords.data());
  return make_grid(coords, 0.25, {1, -2, 0.5});
}

/// Faces of voxels without a neighbour, found by their coordinates.
int64_t free_faces(const VoxelGrid& grid) {
  std::set<std::array<int32_t, 3>> there;
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    there.insert({grid.voxel_coord(v, 0), grid.voxel_coord(v, 1), grid.voxel_coord(v, 2)});
  int64_t count = 0;
  for (const std::array<int32_t, 3>& at : there)
    for (size_t d = 0; d < 3; ++d)
      for (const int step : {-1, 1}) {
        std::array<int32_t, 3> beside = at;
        beside[d] += step;
        count += !there.count(beside);
      }
  return count;
}

TEST(VoxelTets, VolumesArePositiveAndSumToThoseOfTheVoxels) {
  const Scene scene = scene_of(ragged_grid());
  const double six_voxels = 6 * 0.25 * 0.25 * 0.25;  // exact in binary, as are all sums
  for (const VoxelSplit split : kBoth) {
    const int n = split == VoxelSplit::kFive ? 5 : 6;
    const ElementMesh mesh = voxel_tets(scene, split);
    ASSERT_EQ(mesh.element, Element::kTet4);
    ASSERT_EQ(mesh.elements.rows(), n * scene.grid.voxel_count());
    EXPECT_EQ(mesh.rest, scene.grid.rest);
    for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) {
      double sum = 0;
      for (int t = 0; t < n; ++t) {
        sum += tet_determinant(mesh, n * v + t);
        EXPECT_EQ(mesh.material(n * v + t), scene.material(v));
      }
      EXPECT_EQ(sum, six_voxels);
    }
    EXPECT_EQ(determinants(mesh).least, six_voxels / 6);
    EXPECT_EQ(determinants(mesh).most, n == 5 ? six_voxels / 3 : six_voxels / 6);
  }
}

TEST(VoxelTets, FacesConformOverTheParityOfTheLattice) {
  const Scene scene = scene_of(ragged_grid());
  const int64_t border = 2 * free_faces(scene.grid), voxels = scene.grid.voxel_count();
  for (const VoxelSplit split : kBoth) {
    const int64_t tets = (split == VoxelSplit::kFive ? 5 : 6) * voxels;
    const test::Faces f = faces(voxel_tets(scene, split));
    EXPECT_EQ(f.wrong, 0);
    EXPECT_EQ(f.border, border);
    EXPECT_EQ(f.inner, (4 * tets - border) / 2);
  }
}

TEST(VoxelTets, FiveOfOneVoxelCutNoCornerTwice) {
  // each node of a voxel is the tip of one corner tetrahedron or in the middle one, never both
  for (const int shift : {0, 1}) {
    Array<int32_t> coords(1, 3);
    coords(0, 0) = shift;
    const ElementMesh mesh = voxel_tets(scene_of(make_grid(coords, 1, {})), VoxelSplit::kFive);
    std::map<int32_t, int> uses;
    for (int64_t k = 0; k < mesh.elements.size(); ++k) ++uses[mesh.elements.data()[k]];
    int tips = 0;
    for (const auto& [node, count] : uses) {
      EXPECT_TRUE(count == 1 || count == 4);  // the middle one and the three tips beside it
      tips += count == 1;
    }
    EXPECT_EQ(tips, 4);
    EXPECT_EQ(uses[0], shift == 0 ? 1 : 4);
  }
}

TEST(VoxelTets, RefusesScenesWithoutVoxelsOrMaterials) {
  expect_says(error_of([] { voxel_tets(Scene{}, VoxelSplit::kSix); }, ErrorKind::kUsage),
              "a material for each of the voxels");
  Scene scene = scene_of(make_box(2, 1, 1, 1));
  scene.material = Array<int32_t>(1);
  expect_says(error_of([&] { voxel_tets(scene, VoxelSplit::kFive); }, ErrorKind::kUsage),
              "got (1, 1) for 2 voxels");
  expect_says(error_of([] { kuhn_tets(Array<int32_t>(2, 4)); }, ErrorKind::kUsage), "(2, 4)");
}

TEST(Quadratic, PutsOneNodeInTheMiddleOfEachEdge) {
  const ElementMesh linear = voxel_tets(scene_of(ragged_grid()), VoxelSplit::kFive);
  const ElementMesh mesh = quadratic(linear);
  ASSERT_EQ(mesh.element, Element::kTet10);
  EXPECT_EQ(mesh.material, linear.material);
  EXPECT_EQ(mesh.rest.rows(), linear.rest.rows() + edge_count(linear));
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  std::set<int32_t> used;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    for (int k = 0; k < 4; ++k) EXPECT_EQ(mesh.elements(e, k), linear.elements(e, k));
    for (int k = 0; k < 6; ++k) {
      const int32_t middle = mesh.elements(e, 4 + k);
      used.insert(middle);
      for (int d = 0; d < 3; ++d)  // all coordinates are exact in binary
        EXPECT_EQ(2 * mesh.rest(middle, d), mesh.rest(mesh.elements(e, kEdges[k][0]), d) +
                                                mesh.rest(mesh.elements(e, kEdges[k][1]), d));
    }
  }
  EXPECT_EQ(int64_t(used.size()), edge_count(linear));
  EXPECT_GE(*used.begin(), linear.rest.rows());
}

TEST(Refined, HasEightTimesTheTetrahedraInTheSameVolume) {
  for (const VoxelSplit split : kBoth) {
    const ElementMesh coarse = voxel_tets(scene_of(ragged_grid()), split);
    const ElementMesh fine = refined(coarse);
    ASSERT_EQ(fine.elements.rows(), 8 * coarse.elements.rows());
    EXPECT_EQ(fine.rest.rows(), coarse.rest.rows() + edge_count(coarse));
    for (int64_t e = 0; e < fine.elements.rows(); ++e) {
      EXPECT_EQ(tet_determinant(fine, e), tet_determinant(coarse, e / 8) / 8);  // exact
      EXPECT_EQ(fine.material(e), coarse.material(e / 8));
    }
    const test::Faces before = faces(coarse), after = faces(fine);
    EXPECT_EQ(after.wrong, 0);
    EXPECT_EQ(after.border, 4 * before.border);
    EXPECT_EQ(after.inner, (4 * fine.elements.rows() - after.border) / 2);
  }
}

/// Least volume of a tetrahedron over that of the regular one with its longest edge.
double least_quality(const ElementMesh& mesh) {
  double least = 1;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    double longest = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        longest = std::max(longest, norm(minus(test::place(mesh.rest, mesh.elements(e, a)),
                                               test::place(mesh.rest, mesh.elements(e, b)))));
    least =
        std::min(least, tet_determinant(mesh, e) * std::sqrt(2) / (longest * longest * longest));
  }
  return least;
}

TEST(Refined, KeepsTheShapesAgainAndAgain) {
  // Kuhn's tetrahedra come out as Kuhn's, each of the quality sqrt(2)/sqrt(27)
  ElementMesh mesh = box_tets(1, 1, 1, {0, 0, 0}, {1, 1, 1});
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(least_quality(mesh), std::sqrt(2. / 27), 1e-14);
    mesh = refined(mesh);
  }
  EXPECT_NEAR(least_quality(mesh), std::sqrt(2. / 27), 1e-14);
}

TEST(Refined, OnlyTakesLinearTetrahedraWithTheirNodes) {
  ElementMesh mesh = box_tets(1, 1, 1, {0, 0, 0}, {1, 1, 1});
  const ElementMesh middles = quadratic(mesh);
  expect_says(error_of([&] { refined(middles); }, ErrorKind::kUsage), "got elements (6, 10)");
  mesh.elements(2, 1) = 8;
  expect_says(error_of([&] { quadratic(mesh); }, ErrorKind::kUsage),
              "corner 1 of element 2 is node 8, there are 8");
  mesh.elements = Array<int32_t>(0, 4);
  mesh.material = Array<int32_t>(0);
  EXPECT_EQ(refined(mesh).elements.rows(), 0);
}

}  // namespace
}  // namespace elastogen::fem
