// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/stencil_bricks.hpp"

#include "network/precondition/multigrid.hpp"
#include "tests/network/precondition/multigrid_scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

using stencil::kComponent;
using stencil::kRow;
using stencil::kSlots;

/// The rows of all nodes of a level, one each, computed from Multigrid's level.
class Rows {
 public:
  Rows(const MultigridLevel<double>& of, const BrickLevel& bricks)
      : of_(of), bricks_(bricks), rows_(size_t(of.nodes * kRow)) {
    for (int64_t n = 0; n < of.nodes; ++n) {
      if (of.pinned[size_t(n)]) continue;
      uint32_t pins = 0;
      for (int j = 0; j < 27; ++j)
        if (const int64_t there = beside(n, j); there >= 0 && of.pinned[size_t(there)])
          pins |= 1u << j;
      for (int i = 0; i < 3; ++i)
        stencil_row<double>(
            i, [&](int c, double k[6], double M[7]) { return voxel(n, c, k, M); }, pins,
            of.added[size_t(3 * n + i)], rows_.data() + n * kRow + i * kComponent);
    }
  }

  /// The row of a component.
  const double* operator()(int64_t n, int i) const {
    return rows_.data() + n * kRow + i * kComponent;
  }

  /// Node j of the 27 around n, found by slots and links; -1 where there is none.
  int64_t beside(int64_t n, int j) const {
    const int32_t* at = of_.node_coord.row(n);
    const int64_t brick = bricks_.nodes.find_brick(brick_key({at[0], at[1], at[2]}) >> 9);
    const int x = (at[0] & 7) + j % 3 + 7, y = (at[1] & 7) + j / 3 % 3 + 7,
              z = (at[2] & 7) + j / 9 + 7;  // plus 8
    const int32_t there = bricks_.links[size_t(brick)].neighbour[x / 8 + 3 * (y / 8) + 9 * (z / 8)];
    if (there == bricks_.brick_count()) return -1;
    return bricks_.nodes.find(there, x % 8 | y % 8 << 3 | z % 8 << 6);
  }

  /// The product by rows alone; 0 on pinned nodes.
  std::vector<double> product(const std::vector<double>& p) const {
    std::vector<double> result(p.size());
    for (int64_t n = 0; n < of_.nodes; ++n)
      for (int j = 0; j < 27; ++j)
        if (const int64_t there = beside(n, j); there >= 0)
          for (int i = 0; i < 3; ++i)
            result[size_t(3 * n + i)] += (*this)(n, i)[j] * p[size_t(3 * there + i)];
    return result;
  }

 private:
  bool voxel(int64_t n, int c, double k[6], double M[7]) const {
    const int32_t* at = of_.node_coord.row(n);
    const int64_t v =
        bricks_.voxels.find({at[0] - (c & 1), at[1] - (c >> 1 & 1), at[2] - (c >> 2)});
    if (v < 0) return false;
    const int32_t slot = of_.rows.slot[size_t(v)], row = slot / kLanes, lane = slot % kLanes;
    for (int j = 0; j < 6; ++j) k[j] = of_.moduli[size_t((row * 6 + j) * kLanes + lane)];
    const int32_t border = of_.rows.rows[size_t(row)].border;
    for (int m = 0; m < 7; ++m)
      M[m] = border < 0 ? 0 : of_.rows.border[size_t((border * 7 + m) * kLanes + lane)];
    return true;
  }

  const MultigridLevel<double>& of_;
  const BrickLevel& bricks_;
  std::vector<double> rows_;
};

std::vector<BrickLevel> levels_of(const Scene& scene) {
  return make_stencil_levels(scene.grid, dense_nodes(scene));
}

TEST(StencilBricks, LevelsAreThoseOfTheMultigrid) {
  for (const NamedScene& named : multigrid_scenes()) {
    SCOPED_TRACE(named.name);
    const Multigrid<float> multigrid(named.scene, 1);
    const std::vector<BrickLevel> bricks = levels_of(named.scene);
    ASSERT_EQ(int(bricks.size()), multigrid.level_count());
    for (size_t l = 0; l < bricks.size(); ++l) {
      const Array<int32_t> found = bricks[l].nodes.points();
      const Array<int32_t>& expected = multigrid.level(int(l)).node_coord;
      ASSERT_EQ(found.rows(), expected.rows());
      EXPECT_TRUE(std::equal(found.data(), found.data() + found.size(), expected.data()));
      for (int64_t b = 0; b < bricks[l].brick_count(); ++b)  // none is there for nothing
        ASSERT_LT(bricks[l].nodes.first(b), b + 1 < bricks[l].brick_count()
                                                ? bricks[l].nodes.first(b + 1)
                                                : bricks[l].nodes.point_count());
    }
  }
}

TEST(StencilBricks, ProductIsThatOfTheMultigrid) {
  for (const NamedScene& named : multigrid_scenes()) {
    SCOPED_TRACE(named.name);
    const Scene& scene = named.scene;
    Multigrid<double> multigrid(scene, 1);
    const std::vector<BrickLevel> bricks = levels_of(scene);
    for (const bool stiffened : {false, true}) {
      if (stiffened) multigrid.set_nodal_stiffness(some_stiffness(scene));
      std::vector<double> p = random_field(scene, 1, 5), expected(p.size());
      multigrid.operator_product(p.data(), expected.data());
      const MultigridLevel<double> level = multigrid.level(0);
      std::vector<double> found = Rows(level, bricks[0]).product(p);
      for (double& value : found) value *= level.unit;
      EXPECT_LT(relative_difference(found, expected), 1e-13);
    }
  }
}

TEST(StencilBricks, RowsHoldTheInverseDiagonal) {
  const Scene scene = ragged_of_two_materials(19, 13, 11);
  const Multigrid<double> multigrid(scene, 1);
  const std::vector<BrickLevel> bricks = levels_of(scene);
  for (int l = 0; l < multigrid.level_count(); ++l) {
    const MultigridLevel<double> level = multigrid.level(l);
    const Rows rows(level, bricks[size_t(l)]);
    for (int64_t n = 0; n < level.nodes; ++n)
      for (int i = 0; i < 3; ++i) {
        if (level.pinned[size_t(n)]) continue;
        const double* row = rows(n, i);
        ASSERT_NEAR(row[13] * row[27], 1, 1e-14);
        ASSERT_NEAR(row[27] / level.inverse_diagonal[size_t(3 * n + i)], 1, 1e-13);
      }
  }
}

TEST(StencilBricks, WeightsOfPinnedNodesAreNothing) {
  const Scene scene = ragged_of_two_materials(19, 13, 11);
  const Multigrid<double> multigrid(scene, 1);
  const std::vector<BrickLevel> bricks = levels_of(scene);
  const MultigridLevel<double> level = multigrid.level(0);
  const Rows rows(level, bricks[0]);
  const std::vector<double> p = random_field(scene, 1, 6);
  std::vector<double> q = p;
  for (size_t k = 0; k < q.size(); ++k)
    if (scene.pinned(int64_t(k / 3))) q[k] = 1e3;
  ASSERT_NE(p, q);
  EXPECT_EQ(rows.product(p), rows.product(q));
}

TEST(StencilBricks, LinksOfTwoLevelsAreEachOthers) {
  const Scene scene = box_at({-9, -8, -1}, 40, 30, 20);
  const std::vector<BrickLevel> levels = levels_of(scene);
  ASSERT_GE(levels.size(), 2u);
  const BrickLevel &fine = levels[0], &coarse = levels[1];
  int links = 0;
  for (int64_t b = 0; b < coarse.brick_count(); ++b)
    for (int c = 0; c < 27; ++c) {
      const int32_t below = coarse.links[size_t(b)].fine[c];
      if (below == int32_t(fine.brick_count())) continue;
      const int offset[3] = {c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1};
      const Coord at = coarse.nodes.first_place(b), child = fine.nodes.first_place(below);
      for (size_t d = 0; d < 3; ++d) ASSERT_EQ(child[d], 2 * at[d] + 8 * offset[d]);
      if (offset[0] < 0 || offset[1] < 0 || offset[2] < 0) continue;
      // coarse links of a brick count from (coordinate - 1) / 2, rounded down: brick b has offset 1
      // on axes where the coordinate of `below` is even, and offset 0 where it is odd
      int place = 0;
      for (int d = 0; d < 3; ++d) place |= (offset[d] == 0) << d;
      ASSERT_EQ(fine.links[size_t(below)].coarse[place], int32_t(b));
      ++links;
    }
  EXPECT_EQ(links, fine.brick_count());
}

}  // namespace
}  // namespace elastogen::test
