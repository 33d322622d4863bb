// SPDX-License-Identifier: Apache-2.0
#include "network/stencil_bricks.hpp"

#include "tests/network/multigrid_scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// The product by the rows and links alone, node by node; 0 on pinned nodes.
std::vector<double> product(const StencilBricks<double>& g, const std::vector<double>& p) {
  std::vector<double> at_slot(3 * stencil::kSlots * size_t(g.brick_count() + 1)), result(p.size());
  for (size_t k = 0; k < p.size(); ++k) at_slot[size_t(3 * g.slot[k / 3]) + k % 3] = p[k];
  for (size_t k = 0; k < p.size(); ++k) {
    const int slot = g.slot[k / 3], brick = slot / stencil::kSlots;
    for (int c = 0; c < 27; ++c) {
      const int x = slot % 8 + c % 3 + 7, y = slot / 8 % 8 + c / 3 % 3 + 7,
                z = slot / 64 % 8 + c / 9 + 7;  // plus 8
      const int there = g.links[size_t(brick)].neighbour[x / 8 + 3 * (y / 8) + 9 * (z / 8)];
      const int neighbour = stencil::kSlots * there + x % 8 + 8 * (y % 8) + 64 * (z % 8);
      const size_t weight =
          size_t(g.row[size_t(slot)]) * stencil::kRow + k % 3 * stencil::kComponent + size_t(c);
      result[k] += g.rows[weight] * at_slot[size_t(3 * neighbour) + k % 3];
    }
  }
  return result;
}

TEST(StencilBricks, ProductIsThatOfTheMultigrid) {
  for (const NamedScene& named : multigrid_scenes()) {
    SCOPED_TRACE(named.name);
    const Scene& scene = named.scene;
    Multigrid<double> multigrid(scene, 1);
    for (const bool stiffened : {false, true}) {
      if (stiffened) multigrid.set_nodal_stiffness(some_stiffness(scene));
      const std::vector<double> p = random_field(scene, 1, 5);
      std::vector<double> expected(p.size());
      multigrid.operator_product(p.data(), expected.data());
      std::vector<double> found = product(make_stencil_bricks(multigrid.level(0)), p);
      for (double& value : found) value *= multigrid.level(0).unit;
      EXPECT_LT(relative_difference(found, expected), 1e-13);
    }
  }
}

TEST(StencilBricks, RowsHoldTheInverseDiagonalAndNothingWherePinned) {
  const Scene scene = ragged_of_two_materials(19, 13, 11);
  Multigrid<double> multigrid(scene, 1);
  for (int l = 0; l < multigrid.level_count(); ++l) {
    const MultigridLevel<double> level = multigrid.level(l);
    const StencilBricks<double> g = make_stencil_bricks(level);
    for (size_t k = 0; k < level.added.size(); ++k) {
      const double* row = g.rows.data() + size_t(g.row[size_t(g.slot[k / 3])]) * stencil::kRow +
                          k % 3 * stencil::kComponent;
      ASSERT_EQ(row[27], level.inverse_diagonal[k]);
      if (level.pinned[k / 3])
        ASSERT_EQ(row[13], 0);
      else
        ASSERT_NEAR(row[13] * row[27], 1, 1e-14);
    }
  }
}

TEST(StencilBricks, WeightsOfPinnedNodesAreNothing) {
  const Scene scene = ragged_of_two_materials(19, 13, 11);
  Multigrid<double> multigrid(scene, 1);
  const StencilBricks<double> g = make_stencil_bricks(multigrid.level(0));
  const std::vector<double> p = random_field(scene, 1, 6);
  std::vector<double> q = p;
  for (size_t k = 0; k < q.size(); ++k)
    if (scene.pinned(int64_t(k / 3))) q[k] = 1e3;
  ASSERT_NE(p, q);
  EXPECT_EQ(product(g, p), product(g, q));
}

TEST(StencilBricks, AUniformBlockNeedsARowForEachKindOfNode) {
  // inner nodes, faces, edges and corners are 27 kinds; row 0 is that of no node
  const Scene scene = box_at({-9, -8, -1}, 40, 30, 20);
  Multigrid<float> multigrid(scene, 1);
  EXPECT_EQ(int64_t(make_stencil_bricks(multigrid.level(0)).rows.size()) / stencil::kRow, 28);
}

TEST(StencilBricks, AreTheSameForOneAndTwoThreads) {
  const Scene scene = ragged_of_two_materials(19, 13, 11);
  const Multigrid<float> multigrid(scene, 1);
  StencilBricks<float> built[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    built[threads - 1] = make_stencil_bricks(multigrid.level(0));
  }
  EXPECT_EQ(built[0].coord, built[1].coord);
  EXPECT_EQ(built[0].begin, built[1].begin);
  EXPECT_EQ(built[0].slot, built[1].slot);
  EXPECT_EQ(built[0].row, built[1].row);
  EXPECT_EQ(built[0].rows, built[1].rows);
}

TEST(StencilBricks, LinksOfTwoLevelsAreEachOthers) {
  const Scene scene = box_at({-9, -8, -1}, 40, 30, 20);
  Multigrid<double> multigrid(scene, 1);
  StencilBricks<double> fine = make_stencil_bricks(multigrid.level(0)),
                        coarse = make_stencil_bricks(multigrid.level(1));
  link_levels(fine, coarse);
  int links = 0;
  for (size_t b = 0; b < coarse.coord.size(); ++b)
    for (int c = 0; c < 27; ++c) {
      const int32_t below = coarse.links[b].fine[c];
      if (below == int32_t(fine.brick_count())) continue;
      const int offset[3] = {c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1};
      for (int d = 0; d < 3; ++d)
        ASSERT_EQ(fine.coord[size_t(below)][size_t(d)], 2 * coarse.coord[b][size_t(d)] + offset[d]);
      if (offset[0] < 0 || offset[1] < 0 || offset[2] < 0) continue;
      // one before half the coordinate where that is even: what lies before the brick has it too
      int place = 0;
      for (int d = 0; d < 3; ++d) place |= (offset[d] == 0) << d;
      ASSERT_EQ(fine.links[size_t(below)].coarse[place], int32_t(b));
      ++links;
    }
  EXPECT_EQ(links, fine.brick_count());
}

}  // namespace
}  // namespace elastogen::test
