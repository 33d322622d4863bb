// SPDX-License-Identifier: Apache-2.0
#include "core/bricks/links.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

/// The bricks of a bar of 40 x 3 x 3 voxels that lies across the zero of the lattice, and those of
/// twice the edge.
std::vector<BrickLevel> bar() {
  Array<int32_t> coords(40 * 9, 3);
  for (int k = 0; k < 40 * 9; ++k) {
    coords(k, 0) = k % 40 - 20;
    coords(k, 1) = k / 40 % 3 - 1;
    coords(k, 2) = k / 120;
  }
  std::vector<BrickLevel> levels(2);
  levels[0].voxels = BrickIndex(coords);
  levels[0].nodes = levels[0].voxels.corners();
  levels[1].voxels = levels[0].voxels.halved();
  levels[1].nodes = levels[1].voxels.corners();
  link_bricks(levels);
  return levels;
}

TEST(BrickLinks, NeighboursAreEachOthers) {
  for (const BrickLevel& level : bar()) {
    const auto none = int32_t(level.brick_count());
    int neighbours = 0;
    for (int32_t b = 0; b < none; ++b) {
      const BrickLinks& links = level.links[size_t(b)];
      EXPECT_EQ(links.neighbour[13], b);
      const Coord at = level.nodes.first_place(b);
      EXPECT_EQ(links.odd, (at[0] >> 3 & 1) | (at[1] >> 3 & 1) << 1 | (at[2] >> 3 & 1) << 2);
      for (int j = 0; j < 27; ++j) {
        const int32_t there = links.neighbour[j];
        if (there == none) continue;
        ++neighbours;
        EXPECT_EQ(level.links[size_t(there)].neighbour[26 - j], b);
        const Coord to = level.nodes.first_place(there);
        EXPECT_EQ(to, (Coord{at[0] + 8 * (j % 3 - 1), at[1] + 8 * (j / 3 % 3 - 1),
                             at[2] + 8 * (j / 9 - 1)}));
      }
    }
    EXPECT_GT(neighbours, none);
  }
}

TEST(BrickLinks, VoxelsAreAtHomeInTheBrickOfTheirPlace) {
  for (const BrickLevel& level : bar())
    for (int64_t b = 0; b < level.voxels.brick_count(); ++b)
      EXPECT_EQ(level.nodes.first_place(level.node_brick[size_t(b)]), level.voxels.first_place(b));
}

TEST(BrickLinks, TakeNoLevels) {
  std::vector<BrickLevel> levels(1);
  link_bricks(levels);
  EXPECT_TRUE(levels[0].links.empty());
}

}  // namespace
}  // namespace elastogen
