// SPDX-License-Identifier: Apache-2.0
#include "network/potential/brick_rows.hpp"

#include "core/hex8.hpp"
#include "core/parallel.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

#include <atomic>

namespace elastogen::test {
namespace {

/// A ragged block over several bricks with two materials in turn along x.
struct Fixture {
  VoxelGrid grid = ragged_grid(19, 11, 10, 0.1, 3);
  Array<int32_t> material{grid.voxel_count()};
  double kernel[24][24];
  std::vector<double> weight, field;

  Fixture() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (auto& row : kernel)
      for (double& k : row) k = uniform(random);
    for (int64_t v = 0; v < grid.voxel_count(); ++v) {
      material(v) = int32_t(random() % 2);
      weight.push_back(uniform(random));
    }
    field.resize(3 * size_t(grid.node_count()));
    for (double& value : field) value = uniform(random);
  }

  /// weight (kernel u) of each voxel, summed on its corners.
  std::vector<double> naive_sums() const {
    std::vector<double> result(field.size());
    for (int64_t v = 0; v < grid.voxel_count(); ++v)
      for (int a = 0; a < 24; ++a)
        for (int b = 0; b < 24; ++b)
          result[size_t(3 * grid.corners(v, a % 8) + a / 8)] +=
              weight[size_t(v)] * kernel[a][b] * field[size_t(3 * grid.corners(v, b % 8) + b / 8)];
    return result;
  }

  /// naive_sums by for_each_row; counts how often each node is finished.
  std::vector<double> row_sums(std::vector<int>& finished) const {
    const BrickRows rows = make_brick_rows(grid, material);
    BrickScratch<double> scratch(rows);
    std::vector<NoSums> sums;
    std::vector<double> result(field.size());
    finished.assign(size_t(grid.node_count()), 0);
    for_each_row(
        rows, scratch, sums,
        [&](int64_t n, int64_t, double value[3]) {
          for (int i = 0; i < 3; ++i) value[i] = field[size_t(3 * n + i)];
        },
        // forces of a row of voxels; lanes without a voxel have weight 0
        [&](int64_t r, const Pack<double> u[3][8], Pack<double> f[3][8], NoSums&) {
          Pack<double> w{};
          for (int lane = 0; lane < kLanes; ++lane) {
            const int32_t v = rows.voxel[size_t(r * kLanes + lane)];
            if (v >= 0) w[lane] = weight[size_t(v)];
          }
          for (int a = 0; a < 24; ++a) {
            f[a / 8][a % 8] = Pack<double>{};
            for (int b = 0; b < 24; ++b) f[a / 8][a % 8] += w * kernel[a][b] * u[b / 8][b % 8];
          }
        },
        [&](int64_t n, const double sum[3]) {
          ++finished[size_t(n)];
          for (int i = 0; i < 3; ++i) result[size_t(3 * n + i)] = sum[i];
        });
    return result;
  }
};

TEST(BrickRows, SumsOverVoxelsAgreeWithTheLoopOverCorners) {
  const Fixture f;
  std::vector<int> finished;
  const std::vector<double> sums = f.row_sums(finished), expected = f.naive_sums();
  EXPECT_LT(relative_difference(sums, expected), 1e-14);
  for (size_t n = 0; n < finished.size(); ++n) ASSERT_EQ(finished[n], 1) << "node " << n;
}

TEST(BrickRows, GiveTheSameBitsForOneAndTwoThreads) {
  const Fixture f;
  std::vector<int> finished;
  std::vector<double> sums[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit control(threads);
    sums[threads - 1] = f.row_sums(finished);
  }
  EXPECT_EQ(sums[0], sums[1]);
}

TEST(BrickRows, AreTheSameForOneAndTwoThreads) {
  const Fixture f;
  BrickRows rows[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit control(threads);
    rows[threads - 1] = make_brick_rows(f.grid, f.material);
  }
  EXPECT_EQ(rows[0].slot, rows[1].slot);
  EXPECT_EQ(rows[0].voxel, rows[1].voxel);
  EXPECT_EQ(rows[0].row_begin, rows[1].row_begin);
  EXPECT_EQ(rows[0].tile_node, rows[1].tile_node);
  EXPECT_EQ(rows[0].tile_place, rows[1].tile_place);
  EXPECT_EQ(rows[0].tile_part, rows[1].tile_part);
  EXPECT_EQ(rows[0].shared_node, rows[1].shared_node);
  EXPECT_EQ(rows[0].shared_begin, rows[1].shared_begin);
  EXPECT_EQ(rows[0].border, rows[1].border);
}

TEST(BrickRows, PartsOfANodeStandInTheOrderOfItsBricks) {
  const Fixture f;
  const BrickRows rows = make_brick_rows(f.grid, f.material);
  std::vector<std::vector<int32_t>> parts(size_t(f.grid.node_count()));
  for (size_t k = 0; k < rows.tile_node.size(); ++k)
    parts[size_t(rows.tile_node[k])].push_back(rows.tile_part[k]);
  size_t shared = 0;
  for (size_t n = 0; n < parts.size(); ++n) {
    if (parts[n].size() == 1) {
      ASSERT_EQ(parts[n][0], -1);
      continue;
    }
    ASSERT_EQ(rows.shared_node[shared], int32_t(n));
    for (size_t k = 0; k < parts[n].size(); ++k)
      ASSERT_EQ(parts[n][k], rows.shared_begin[shared] + int32_t(k));
    ASSERT_EQ(rows.shared_begin[++shared], parts[n].back() + 1);
  }
  EXPECT_EQ(shared, rows.shared_node.size());
  EXPECT_GT(shared, 100u);
}

TEST(BrickRows, HoldEveryVoxelOnceInARowOfItsMaterial) {
  const Fixture f;
  const BrickRows rows = make_brick_rows(f.grid, f.material);
  EXPECT_GT(rows.brick_count(), 8);
  int64_t voxels = 0;
  for (int64_t slot = 0; slot < kLanes * rows.row_count(); ++slot) {
    const VoxelRow& row = rows.rows[size_t(slot / kLanes)];
    const int32_t v = rows.voxel[size_t(slot)];
    ASSERT_EQ(row.mask >> (slot % kLanes) & 1, v >= 0);
    if (v < 0) continue;
    ++voxels;
    EXPECT_EQ(rows.slot[size_t(v)], slot);
    EXPECT_EQ(row.material, f.material(v));
    EXPECT_EQ(f.grid.voxel_coord(v, 0) & 7, slot % kLanes);
  }
  EXPECT_EQ(voxels, f.grid.voxel_count());
}

TEST(BrickRows, HoldTheMomentsOfBorderVoxelsAndNoneOfFullOnes) {
  const Fixture f;
  const BrickRows rows = make_brick_rows(f.grid, f.material);
  int64_t with_border = 0;
  for (int64_t v = 0; v < f.grid.voxel_count(); ++v) {
    // moments of the shape functions, signed by the corners
    double M[7] = {};
    bool full = true;
    for (int c = 0; c < 8; ++c) full &= f.grid.shape_mean(v, c) == 0.125;
    for (int p = 1; p < 7; ++p)
      for (int c = 0; c < 8; ++c) {
        double sign = 1;
        for (int d = 0; d < 3; ++d)
          if (p >> d & 1) sign *= c >> d & 1 ? 1 : -1;
        M[p] += sign * f.grid.shape_mean(v, c);
      }
    // a row has border numbers if one of its voxels is not full
    const size_t slot = size_t(rows.slot[size_t(v)]), row = slot / kLanes;
    const int32_t border = rows.rows[row].border;
    if (!full) {
      ASSERT_GE(border, 0);
    }
    if (border < 0) continue;
    with_border += !full;
    for (int p = 1; p < 7; ++p)
      ASSERT_NEAR(rows.border[size_t(border * 7 + p) * kLanes + slot % kLanes], full ? 0 : M[p],
                  1e-15);
  }
  EXPECT_GT(with_border, 100);
}

}  // namespace
}  // namespace elastogen::test
