// SPDX-License-Identifier: Apache-2.0
#include "voxelize/bricks.hpp"

#include "core/bricks/index.hpp"
#include "core/error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

namespace elastogen {
namespace {

using Coord = std::array<int, 3>;

Array<int32_t> to_array(const std::vector<Coord>& coords) {
  Array<int32_t> result(static_cast<int64_t>(coords.size()), 3);
  for (int64_t v = 0; v < result.rows(); ++v)
    for (int d = 0; d < 3; ++d) result(v, d) = coords[v][d];
  return result;
}

/// Each point of [lower, upper)^3 with the given probability, in random order.
std::vector<Coord> random_voxels(int lower, int upper, double share, unsigned seed) {
  std::mt19937 random(seed);
  std::bernoulli_distribution take(share);
  std::vector<Coord> points;
  for (int z = lower; z < upper; ++z)
    for (int y = lower; y < upper; ++y)
      for (int x = lower; x < upper; ++x)
        if (take(random)) points.push_back({x, y, z});
  std::shuffle(points.begin(), points.end(), random);
  return points;
}

/// Written after the definition: bit by bit, most significant first.
bool precedes(const Coord& a, const Coord& b) {
  for (int bit = 20; bit >= 3; --bit)
    for (int d = 2; d >= 0; --d) {
      const int x = (a[d] + (1 << 20)) >> bit & 1, y = (b[d] + (1 << 20)) >> bit & 1;
      if (x != y) return x < y;
    }
  for (int d = 2; d >= 0; --d)
    if ((a[d] & 7) != (b[d] & 7)) return (a[d] & 7) < (b[d] & 7);
  return false;
}

Coord row(const Array<int32_t>& coords, int64_t r) {
  return {coords(r, 0), coords(r, 1), coords(r, 2)};
}

void expect_sorted(const Array<int32_t>& coords) {
  for (int64_t r = 1; r < coords.rows(); ++r)
    ASSERT_TRUE(precedes(row(coords, r - 1), row(coords, r))) << "row " << r;
}

TEST(Bricks, KeepEveryVoxelAndSortByMortonCodeOfTheBrickThenXFastest) {
  const std::vector<Coord> points = random_voxels(-12, 14, 0.3, 1);
  const VoxelGrid grid = make_grid(to_array(points), 0.5, {});
  std::set<Coord> expected(points.begin(), points.end()), got;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) got.insert(row(grid.voxel_coord, v));
  EXPECT_EQ(got, expected);
  EXPECT_EQ(grid.voxel_count(), static_cast<int64_t>(points.size()));
  expect_sorted(grid.voxel_coord);
  expect_sorted(grid.node_coord);
}

TEST(Bricks, TablesAgreeWithAMapOfCoordinates) {
  const VoxelGrid grid = make_grid(to_array(random_voxels(-20, 9, 0.1, 2)), 0.25, {1, -2, 3});
  std::map<Coord, int64_t> node_at;
  for (int64_t n = 0; n < grid.node_count(); ++n) node_at[row(grid.node_coord, n)] = n;
  std::set<Coord> used;
  int64_t entries = 0;
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    for (int c = 0; c < 8; ++c) {
      Coord corner = row(grid.voxel_coord, v);
      for (int d = 0; d < 3; ++d) corner[d] += c >> d & 1;
      used.insert(corner);
      ASSERT_EQ(grid.corners(v, c), node_at.at(corner));
      ASSERT_EQ(grid.voxels(grid.corners(v, c), c), v);
    }
  for (int64_t i = 0; i < grid.voxels.size(); ++i) entries += grid.voxels.data()[i] >= 0;
  EXPECT_EQ(entries, 8 * grid.voxel_count());
  EXPECT_EQ(static_cast<int64_t>(used.size()), grid.node_count());
}

TEST(Bricks, RestPositionsAreOriginPlusEdgeTimesCoordinate) {
  const Vec3 origin = {1, -2, 3};
  const VoxelGrid grid = make_grid(to_array(random_voxels(-3, 9, 0.2, 3)), 0.25, origin);
  for (int64_t n = 0; n < grid.node_count(); ++n)
    for (int d = 0; d < 3; ++d)
      ASSERT_DOUBLE_EQ(grid.rest(n, d), origin[d] + 0.25 * grid.node_coord(n, d));
}

TEST(Bricks, PiecesAreThoseOfAFloodOverSharedNodes) {
  const VoxelGrid grid = make_grid(to_array(random_voxels(-10, 10, 0.05, 4)), 1, {});
  std::vector<int> label(grid.node_count(), -1);
  int pieces = 0;
  for (int32_t start = 0; start < grid.node_count(); ++start) {
    if (label[start] >= 0) continue;
    std::vector<int32_t> open = {start};
    label[start] = pieces;
    while (!open.empty()) {
      const int32_t node = open.back();
      open.pop_back();
      for (int c = 0; c < 8; ++c)
        for (int k = 0; k < 8 && grid.voxels(node, c) >= 0; ++k)
          if (const int32_t next = grid.corners(grid.voxels(node, c), k); label[next] < 0) {
            label[next] = pieces;
            open.push_back(next);
          }
    }
    ++pieces;
  }
  ASSERT_GT(pieces, 10);
  EXPECT_EQ(grid.pieces, pieces);
  for (int64_t n = 0; n < grid.node_count(); ++n) ASSERT_EQ(grid.piece(n), label[n]);
}

TEST(Bricks, ABoxHasTheCountsAndTheVolumeOfABox) {
  const VoxelGrid grid = make_box(9, 5, 17, 0.5, {1, 2, 3});
  EXPECT_EQ(grid.voxel_count(), 9 * 5 * 17);
  EXPECT_EQ(grid.node_count(), 10 * 6 * 18);
  EXPECT_EQ(grid.pieces, 1);
  EXPECT_DOUBLE_EQ(grid.volume, 9 * 5 * 17 * 0.125);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    ASSERT_EQ(grid.fill(v), 1);
    for (int c = 0; c < 8; ++c) ASSERT_EQ(grid.shape_mean(v, c), 0.125);
  }
}

TEST(Bricks, ReachTheEndsOfTheLattice) {
  const int limit = 1 << 20;
  const VoxelGrid grid =
      make_grid(to_array({{limit - 2, limit - 2, limit - 2}, {-limit, -limit, -limit}}), 1, {});
  EXPECT_EQ(grid.node_count(), 16);
  EXPECT_EQ(grid.pieces, 2);
  EXPECT_EQ(row(grid.voxel_coord, 0), (Coord{-limit, -limit, -limit}));
  EXPECT_EQ(row(grid.node_coord, 15), (Coord{limit - 1, limit - 1, limit - 1}));
}

/// Points by map(point), sorted and each once.
template <class Map>
std::vector<Coord> images(const std::vector<Coord>& points, const Map& map) {
  std::set<Coord> found;
  for (const Coord& point : points) map(point, found);
  std::vector<Coord> list(found.begin(), found.end());
  std::sort(list.begin(), list.end(), precedes);
  return list;
}

void expect_points(const BrickIndex& index, const std::vector<Coord>& expected) {
  EXPECT_EQ(index.points(), to_array(expected));
  ASSERT_EQ(index.point_count(), static_cast<int64_t>(expected.size()));
  for (size_t k = 0; k < expected.size(); ++k)
    ASSERT_EQ(index.find(expected[k]), static_cast<int64_t>(k));
}

TEST(BrickIndex, HalvesAndCornersAreThoseOfThePoints) {
  const int32_t limit = 1 << 20;
  for (std::vector<Coord> points :
       {random_voxels(-20, 13, 0.02, 6), random_voxels(-9, 9, 0.6, 7), random_voxels(0, 8, 1, 8),
        std::vector<Coord>{{-limit, -limit, -limit}, {limit - 2, limit - 2, 7}}}) {
    for (const bool in_order : {false, true}) {
      if (in_order) std::sort(points.begin(), points.end(), precedes);
      const BrickIndex index(to_array(points));
      expect_points(index, images(points, [](const Coord& p, auto& to) { to.insert(p); }));
      expect_points(index.halved(), images(points, [](const Coord& p, auto& to) {
                      to.insert({p[0] >> 1, p[1] >> 1, p[2] >> 1});
                    }));
      expect_points(index.corners(), images(points, [](const Coord& p, auto& to) {
                      for (int c = 0; c < 8; ++c)
                        to.insert({p[0] + (c & 1), p[1] + (c >> 1 & 1), p[2] + (c >> 2)});
                    }));
    }
  }
}

TEST(Bricks, TakeNoVoxels) {
  const VoxelGrid grid = make_grid(Array<int32_t>(0, 3), 1, {});
  EXPECT_EQ(grid.node_count(), 0);
  EXPECT_EQ(grid.pieces, 0);
}

TEST(Bricks, RefuseDuplicatesBadEdgesAndFarCoordinates) {
  EXPECT_THROW(make_grid(to_array({{1, 2, 3}, {1, 2, 3}}), 1, {}), Error);
  EXPECT_THROW(make_grid(to_array({{1, 2, 3}}), 0, {}), Error);
  EXPECT_THROW(make_grid(to_array({{1, 2, 3}}), 1, {0, 0.0 / 0.0, 0}), Error);
  EXPECT_THROW(make_grid(to_array({{1 << 20, 0, 0}}), 1, {}), Error);
  EXPECT_THROW(make_grid(to_array({{0, -(1 << 20) - 1, 0}}), 1, {}), Error);
  EXPECT_THROW(make_grid(Array<int32_t>(4, 2), 1, {}), Error);
  EXPECT_THROW(make_box(3, 0, 3, 1), Error);
}

}  // namespace
}  // namespace elastogen
