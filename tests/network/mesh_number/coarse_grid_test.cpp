// SPDX-License-Identifier: Apache-2.0
#include "network/mesh_number/coarse_grid.hpp"

#include "network/mesh_number/coarse_scene.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::ball_grid;
using test::ragged_grid;
using test::scene_on;
using test::solid;

Array<uint8_t> none_held(const VoxelGrid& grid) {
  return Array<uint8_t>(grid.node_count());
}

Array<uint8_t> fixed_of(const Scene& scene) {
  Array<uint8_t> fixed(scene.grid.node_count(), 3);
  for (int64_t n = 0; n < fixed.rows(); ++n) std::fill_n(fixed.row(n), 3, scene.pinned(n));
  return fixed;
}

/// Mass and first moments about the origin of lumped masses.
std::array<double, 4> mass_moments(const Scene& scene) {
  std::array<double, 4> sum = {};
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    sum[0] += scene.mass(n);
    for (int d = 0; d < 3; ++d) sum[size_t(1 + d)] += scene.mass(n) * scene.grid.rest(n, d);
  }
  return sum;
}

TEST(CoarseGrid, KeepsVolumeMassAndCentre) {
  for (const VoxelGrid& grid : {ball_grid(1, 0.23), ragged_grid(9, 7, 5, 0.1, 3)}) {
    Scene fine = scene_on(grid, solid(1e5, 0.3));
    finish_scene(fine);
    const CoarseScene coarse = coarse_scene(fine, fixed_of(fine), 1.0);
    const VoxelGrid& g = coarse.scene.grid;
    EXPECT_EQ(g.h, 2 * grid.h);
    // the volume of the fill, and where it lies in each voxel
    double fine_fill = 0, coarse_fill = 0;
    for (int64_t v = 0; v < grid.voxel_count(); ++v) fine_fill += grid.fill(v);
    for (int64_t v = 0; v < g.voxel_count(); ++v) {
      coarse_fill += 8 * g.fill(v);
      double sum = 0;
      for (int c = 0; c < 8; ++c) sum += g.shape_mean(v, c);
      EXPECT_NEAR(sum, 1, 1e-14);
      EXPECT_LE(g.fill(v), 1);
    }
    EXPECT_NEAR(coarse_fill, fine_fill, 1e-12 * fine_fill);
    // masses
    const auto expected = mass_moments(fine), found = mass_moments(coarse.scene);
    for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(found[k], expected[k], 1e-12 * expected[0]);
  }
}

TEST(CoarseGrid, MakesFullVoxelsOfEightFullChildren) {
  const VoxelGrid fine = make_box(6, 4, 8, 0.1);
  const CoarseGrid coarse = coarse_grid(fine, none_held(fine));
  ASSERT_EQ(coarse.grid.voxel_count(), 24);
  for (int64_t v = 0; v < 24; ++v) {
    EXPECT_EQ(coarse.grid.fill(v), 1);
    for (int c = 0; c < 8; ++c) EXPECT_EQ(coarse.grid.shape_mean(v, c), 0.125);
  }
}

TEST(CoarseGrid, HasTheRestPositionsOfItsNodes) {
  const VoxelGrid fine = ball_grid(1, 0.23);
  const CoarseGrid coarse = coarse_grid(fine, none_held(fine));
  std::vector<double> rest(size_t(fine.rest.size()));
  prolong(coarse, coarse.grid.rest.data(), rest.data());
  for (size_t k = 0; k < rest.size(); ++k) EXPECT_NEAR(rest[k], fine.rest.data()[k], 1e-14);
  std::vector<double> back(size_t(coarse.grid.rest.size()));
  NodeFit(coarse, fine).apply(fine.rest.data(), back.data());
  for (size_t k = 0; k < back.size(); ++k) EXPECT_NEAR(back[k], coarse.grid.rest.data()[k], 1e-12);
}

TEST(CoarseGrid, RestrictionIsTheAdjointOfProlongation) {
  const VoxelGrid fine = ragged_grid(9, 7, 5, 0.1, 4);
  const CoarseGrid coarse = coarse_grid(fine, none_held(fine));
  const Scene a = scene_on(fine, solid(1e5, 0.3)), b = scene_on(coarse.grid, solid(1e5, 0.3));
  const std::vector<double> f = test::random_field(a, 1, 1), c = test::random_field(b, 1, 2);
  std::vector<double> up(f.size()), down(c.size());
  prolong(coarse, c.data(), up.data());
  restrict_sum(coarse, 3, f.data(), down.data());
  EXPECT_NEAR(test::dot(up, f), test::dot(c, down), 1e-12 * test::norm(f) * test::norm(c));
}

TEST(CoarseGrid, LiesOnThePlaneOfPins) {
  for (const double plane : {0.0, 0.1, 0.2}) {  // the last pinned layer is even or odd
    Scene fine = scene_on(make_box(9, 6, 6, 0.1), solid(1e5, 0.3));
    test::pin_below(fine, 0, plane + 0.01);
    finish_scene(fine);
    const CoarseScene coarse = coarse_scene(fine, fixed_of(fine), 1.0);
    double last = -1;
    for (int64_t n = 0; n < coarse.scene.grid.node_count(); ++n)
      if (coarse.scene.pinned(n)) last = std::max(last, coarse.scene.grid.rest(n, 0));
    EXPECT_NEAR(last, plane, 1e-14);
  }
}

TEST(CoarseGrid, KeepsPiecesApart) {
  Array<int32_t> coords(4, 3);
  const int32_t places[4][3] = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {3, 1, 0}};  // a gap of one voxel
  for (int v = 0; v < 4; ++v) std::copy_n(places[v], 3, coords.row(v));
  const VoxelGrid fine = make_grid(coords, 0.1, {});
  ASSERT_EQ(fine.pieces, 2);
  const CoarseGrid coarse = coarse_grid(fine, none_held(fine));
  EXPECT_EQ(coarse.grid.pieces, 2);
  std::vector<double> rest(size_t(fine.rest.size()));
  prolong(coarse, coarse.grid.rest.data(), rest.data());
  for (size_t k = 0; k < rest.size(); ++k) EXPECT_NEAR(rest[k], fine.rest.data()[k], 1e-14);
}

TEST(CoarseGrid, TakesTheMaterialOfTheHeaviestChild) {
  Scene fine = scene_on(make_box(4, 2, 2, 0.1), solid(1e5, 0.3));
  fine.materials.push_back(solid(1e6, 0.3, Law::kNeoHookean, 5000));
  for (int64_t v = 0; v < fine.grid.voxel_count(); ++v)
    fine.material(v) = fine.grid.voxel_coord(v, 0) == 1 || fine.grid.voxel_coord(v, 0) == 2;
  finish_scene(fine);
  const CoarseScene coarse = coarse_scene(fine, fixed_of(fine), 1.0);
  ASSERT_EQ(coarse.scene.grid.voxel_count(), 2);
  for (int64_t v = 0; v < 2; ++v) EXPECT_EQ(coarse.scene.material(v), 1);
  EXPECT_NEAR(mass_moments(coarse.scene)[0], mass_moments(fine)[0], 1e-12);
}

}  // namespace
}  // namespace elastogen
