// SPDX-License-Identifier: Apache-2.0
#include "core/bricks/tiles.hpp"

#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

#include <array>

namespace elastogen {
namespace {

/// A voxel gives each of its corners the sum of the values of all of them; summed over the bricks
/// by tiles, (nodes). Whole numbers, so that every order gives the same.
std::vector<double> sums_by_tiles(const VoxelGrid& grid) {
  const std::vector<int32_t> first = first_voxels(grid);
  const BrickTiles g = make_brick_tiles(grid, first);
  BrickScratch<double> scratch(g);
  std::vector<double> result(size_t(grid.node_count()), -1);
  const auto finish = [&](int64_t node, const double sum[3]) { result[size_t(node)] = sum[1]; };
  // each brick reads its tile and adds the sums of its voxels
  run_tasks(g.brick_count(), [&](int64_t b) {
    std::array<double, bricks::kTile> in = {}, out = {};
    read_tile<double>(
        g, b,
        [&](int64_t node, int64_t reference, double value[3]) {
          EXPECT_LE(reference, node);
          value[0] = value[2] = 0, value[1] = double(node);
        },
        [&](int place, const double value[3]) { in[size_t(place)] = value[1]; });
    const int64_t end = size_t(b + 1) < first.size() ? first[size_t(b + 1)] : grid.voxel_count();
    for (int64_t v = first[size_t(b)]; v < end; ++v) {
      const int x = grid.voxel_coord(v, 0) & 7, y = grid.voxel_coord(v, 1) & 7,
                z = grid.voxel_coord(v, 2) & 7;
      std::array<size_t, 8> corner;
      for (int c = 0; c < 8; ++c)
        corner[size_t(c)] = size_t(x + (c & 1) + 9 * (y + (c >> 1 & 1) + 9 * (z + (c >> 2))));
      double sum = 0;
      for (const size_t k : corner) sum += in[k];
      for (const size_t k : corner) out[k] += sum;
    }
    // nodes of one brick are finished here, shared ones after all bricks
    finish_tile(
        g, b, [&](int place, double sum[3]) { sum[0] = sum[2] = 0, sum[1] = out[size_t(place)]; },
        scratch, finish);
  });
  finish_shared(g, scratch, finish);
  return result;
}

TEST(BrickTiles, SumsAreThoseOfTheLoopOverVoxels) {
  for (const VoxelGrid& grid : {make_box(19, 9, 8, 1), make_box(1, 1, 1, 1)}) {
    std::vector<double> expected(size_t(grid.node_count()));
    for (int64_t v = 0; v < grid.voxel_count(); ++v) {
      double sum = 0;
      for (int c = 0; c < 8; ++c) sum += double(grid.corners(v, c));
      for (int c = 0; c < 8; ++c) expected[size_t(grid.corners(v, c))] += sum;
    }
    EXPECT_EQ(sums_by_tiles(grid), expected);
  }
}

TEST(BrickTiles, PartsAreThoseOfNodesOnFacesBetweenBricks) {
  // two bricks along x share 9 x 9 nodes
  const VoxelGrid grid = make_box(16, 8, 8, 1);
  const BrickTiles g = make_brick_tiles(grid, first_voxels(grid));
  EXPECT_EQ(g.brick_count(), 2);
  EXPECT_EQ(g.shared_node.size(), 81u);
  EXPECT_EQ(g.part_count(), 162);
  EXPECT_EQ(g.tile_node.size(), 2u * bricks::kTile);
}

TEST(BrickTiles, TakeNoVoxels) {
  const VoxelGrid grid = make_grid(Array<int32_t>(0, 3), 1, {});
  const BrickTiles g = make_brick_tiles(grid, first_voxels(grid));
  EXPECT_EQ(g.brick_count(), 0);
  EXPECT_EQ(g.part_count(), 0);
}

}  // namespace
}  // namespace elastogen
