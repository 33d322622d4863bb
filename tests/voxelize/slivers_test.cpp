// SPDX-License-Identifier: Apache-2.0
#include "voxelize/slivers.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/voxelize/shapes.hpp"
#include "tests/voxelize/sliver_rules.hpp"
#include "voxelize/bricks.hpp"
#include "voxelize/embedding.hpp"
#include "voxelize/thin_features.hpp"

#include <gtest/gtest.h>

#include <random>

namespace elastogen {
namespace {

using namespace test;

/// Bodies whose slivers are of every kind: round, turned, thinner than a voxel, joined by slivers.
std::vector<std::pair<std::string, Soup>> bodies() {
  const auto at_angle = [](Soup soup, double angle) {
    soup.map([&](const Vec3& p) { return turned(p, angle); });
    return soup;
  };
  std::vector<std::pair<std::string, Soup>> result;
  result.push_back({"sphere", sphere(1, {0.31, 0.17, 0.05}, 5)});
  result.push_back({"bar", at_angle(box({-1, -0.1, -0.1}, {1, 0.1, 0.1}), 0.8)});
  result.push_back({"plate", at_angle(box({0, 0, 0}, {2, 2, 0.005}), 0.3)});
  result.push_back({"needle", at_angle(box({0, 0, 0}, {2, 0.004, 0.005}), 0.8)});
  Soup hair = sphere(0.5, {}, 4);
  hair.add(box({0.7, 0.01, 0.02}, {1.5, 0.013, 0.023}));
  hair.add(box({0.3, 0.01, 0.02}, {0.8, 0.013, 0.023}));
  result.push_back({"hair", at_angle(hair, 0.4)});
  Soup bridge = sphere(0.4, {-0.6, 0, 0}, 4);
  bridge.add(sphere(0.4, {0.6, 0, 0}, 4));
  bridge.add(box({-0.3, -0.002, -0.003}, {0.3, 0.002, 0.003}));
  result.push_back({"bridge", at_angle(bridge, 1.1)});
  return result;
}

TEST(Slivers, OfBodiesGoByTheRulesAndBreakNothing) {
  for (const auto& [name, soup] : bodies())
    for (const int voxels : {17, 40}) {
      const Surface surface = soup.surface();
      const SliverCounts counts = expect_sliver_rules(surface, {.voxels = voxels}, 1 << 20);
      std::printf("%-8s %5ld voxels, %4ld slivers dropped, %4ld kept, hinges %ld to %ld\n",
                  name.c_str(), long(counts.voxels), long(counts.dropped), long(counts.kept),
                  long(counts.hinges_before), long(counts.hinges_after));
    }
}

TEST(Slivers, HairsAndBridgesStayInOnePiece) {
  for (const auto& [name, soup] : bodies())
    for (const int voxels : {17, 40})
      EXPECT_EQ(voxelize(soup.surface(), {.voxels = voxels}).grid.pieces, 1) << name;
}

TEST(Slivers, OfARoundBodyNearlyAllGo) {
  const Soup soup = sphere(1, {0.31, 0.17, 0.05}, 5);
  const VoxelizeReport report = voxelize(soup.surface(), {.voxels = 40}).report;
  EXPECT_GT(report.dropped_slivers, 100);
  EXPECT_LT(report.thin_voxels, report.dropped_slivers / 20);
}

/// Coordinates of the voxels that are dropped, of those given by coordinate and fill.
std::set<Coord> dropped(const Fills& fills) {
  Array<int32_t> coords(static_cast<int64_t>(fills.size()), 3);
  Array<double> fill(coords.rows());
  int64_t v = 0;
  for (const auto& [coord, share] : fills) {
    std::copy(coord.begin(), coord.end(), coords.row(v));
    fill(v++) = share;
  }
  const std::vector<uint8_t> gone = find_slivers(coords, fill);
  std::set<Coord> result;
  for (v = 0; v < coords.rows(); ++v)
    if (gone[v]) result.insert({coords(v, 0), coords(v, 1), coords(v, 2)});
  return result;
}

Fills block(const Coord& lower, const Coord& upper, double fill = 1) {
  Fills result;
  for (int z = lower[2]; z < upper[2]; ++z)
    for (int y = lower[1]; y < upper[1]; ++y)
      for (int x = lower[0]; x < upper[0]; ++x) result[{x, y, z}] = fill;
  return result;
}

TEST(Slivers, ThatHangOnAFaceAnEdgeOrACornerGo) {
  for (const Coord& at : {Coord{3, 1, 1}, {3, 3, 1}, {3, 3, 3}, {-1, -1, -1}}) {
    Fills fills = block({0, 0, 0}, {3, 3, 3});
    fills[at] = 0.01;
    for (const double fill : {0.01, 0.0999}) {
      fills[at] = fill;
      EXPECT_EQ(dropped(fills), std::set<Coord>{at});
    }
    fills[at] = 0.1;
    EXPECT_TRUE(dropped(fills).empty());
  }
}

TEST(Slivers, BelowATenthGoOnceAtMostOneFaceHoldsThem) {
  Fills fills = block({0, 0, 0}, {3, 3, 3});
  // two side by side hold each other, unless one is below 0.02
  fills[{3, 1, 1}] = 0.05;
  fills[{3, 2, 1}] = 0.02;
  EXPECT_TRUE(dropped(fills).empty());
  fills[{3, 2, 1}] = 0.0199;
  EXPECT_EQ(dropped(fills), (std::set<Coord>{{3, 1, 1}, {3, 2, 1}}));
}

TEST(Slivers, EatNoHairFromItsEnds) {
  // straight, diagonal, and with voxels below 0.02 in between; alone and on a block: a tip below
  // 0.02 may go, no more
  for (const bool on_block : {false, true})
    for (const int rise : {0, 1}) {
      for (const double other : {0.05, 0.001}) {
        Fills fills;
        if (on_block) fills = block({0, 0, 0}, {3, 3, 3});
        for (int i = 0; i < 9; ++i) fills[{3 + i, 1 + rise * i, 1}] = i % 2 ? 0.05 : other;
        for (const Coord& coord : dropped(fills))
          EXPECT_TRUE(other < 0.02 && (coord[0] == 11 || (coord[0] == 3 && !on_block)))
              << coord[0] << ' ' << rise << ' ' << other;
      }
    }
}

TEST(Slivers, AloneStay) {
  EXPECT_TRUE(dropped({}).empty());
  EXPECT_TRUE(dropped(block({0, 0, 0}, {1, 1, 1}, 0)).empty());
  EXPECT_TRUE(dropped(block({0, 0, 0}, {9, 1, 1}, 0.001)).empty());
  EXPECT_TRUE(dropped(block({0, 0, 0}, {5, 5, 1}, 0.001)).empty());
}

TEST(Slivers, OfAHairStayButForItsStump) {
  Fills fills = block({0, 0, 0}, {3, 3, 3});
  fills.merge(block({3, 1, 1}, {9, 2, 2}, 0.001));
  EXPECT_TRUE(dropped(fills).empty());
  // a hair of one voxel is a stump
  fills.erase({4, 1, 1});
  EXPECT_EQ(dropped(fills), (std::set<Coord>{{3, 1, 1}}));
}

TEST(Slivers, OfABridgeStay) {
  for (const int length : {1, 2, 5}) {
    Fills fills = block({0, 0, 0}, {3, 3, 3});
    fills.merge(block({3, 1, 1}, {3 + length, 2, 2}, 0.001));
    fills.merge(block({3 + length, 0, 0}, {6 + length, 3, 3}));
    EXPECT_TRUE(dropped(fills).empty()) << length;
  }
}

TEST(Slivers, OfAWallStayWithAllOfItsRoots) {
  // a fin on a block, and a wall between two blocks
  Fills fin = block({0, 0, 0}, {6, 6, 3});
  fin.merge(block({0, 3, 3}, {6, 4, 6}, 0.001));
  EXPECT_TRUE(dropped(fin).empty());
  for (const int gap : {1, 2, 3}) {
    Fills wall = block({0, 0, 0}, {6, 6, 3});
    wall.merge(block({0, 3, 3}, {6, 4, 3 + gap}, 0.001));
    wall.merge(block({0, 0, 3 + gap}, {6, 6, 6 + gap}));
    EXPECT_TRUE(dropped(wall).empty()) << gap;
  }
}

TEST(Slivers, StayWhereOnlyAHingeWouldBeLeft) {
  // two bars that share an edge; slivers join them over faces
  Fills fills = block({0, 0, 0}, {1, 1, 5});
  fills.merge(block({1, 1, 0}, {2, 2, 5}));
  fills.merge(block({1, 0, 0}, {2, 1, 5}, 0.01));
  EXPECT_TRUE(dropped(fills).empty());
  // where the notch is filled on the other side, they go
  fills.merge(block({0, 1, 0}, {1, 2, 5}));
  EXPECT_EQ(dropped(fills).size(), 5u);
}

TEST(Slivers, StayWhereTheyHoldTheRootOfAHairByAFace) {
  // the root of the hair shares only an edge with the body, and a face with the sliver beside it
  Fills fills = block({0, 0, 0}, {3, 3, 3});
  fills[{3, 2, 1}] = 0.001;
  fills[{3, 3, 1}] = 0.01;
  EXPECT_EQ(dropped(fills).size(), 2u);
  fills[{4, 4, 1}] = 0.01;
  EXPECT_TRUE(dropped(fills).empty());
}

TEST(Slivers, GoEmptiestFirstUntilNoneMay) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 60; ++trial) {
    Fills fills;
    const double density = 0.2 + 0.7 * uniform(random), full = 0.5 * uniform(random);
    for (const auto& [coord, fill] : block({-5, 4, 0}, {4, 12, 5}))
      if (uniform(random) < density)
        fills[coord] = uniform(random) < full  ? 1
                       : uniform(random) < 0.5 ? 0.0005 * std::floor(39 * uniform(random))
                                               : 0.005 * std::floor(24 * uniform(random));
    EXPECT_EQ(dropped(fills), dropped_one_by_one(fills)) << trial;
  }
}

TEST(Slivers, OrderOfTheVoxelsAndThreadsDoNotMatter) {
  // a tilted plate thinner than a voxel
  const Soup soup = box({0, 0, 0}, {1, 0.3, 0.01});
  Soup at_angle = soup;
  at_angle.map([](const Vec3& p) { return turned(p, 0.7); });
  const CutBody body = cut_body(at_angle.surface(), {.voxels = 40});
  Array<int32_t> coords = body.voxels();
  Array<double> fill(coords.rows());
  fill.fill(1);
  int64_t v = 0;
  for (int64_t c = 0; c < body.cells.count(); ++c)
    if (body.kept[c]) fill(v++) = body.share(c);
  const std::vector<uint8_t> expected = find_slivers(coords, fill);
  // these voxels in reverse order, on one thread
  Array<int32_t> backward(coords.rows(), 3);
  Array<double> backward_fill(coords.rows());
  for (v = 0; v < coords.rows(); ++v) {
    const int64_t last = coords.rows() - 1 - v;
    std::copy(coords.row(v), coords.row(v) + 3, backward.row(last));
    backward_fill(last) = fill(v);
  }
  const ThreadLimit control(1);
  std::vector<uint8_t> result = find_slivers(backward, backward_fill);
  std::reverse(result.begin(), result.end());
  EXPECT_EQ(result, expected);
  EXPECT_GT(std::count(expected.begin(), expected.end(), 1), 0);
}

TEST(Slivers, LeaveTheSurfaceEmbeddedInTheNearestVoxel) {
  for (const auto& [name, soup] : bodies()) {
    const Surface surface = soup.surface();
    const VoxelGrid grid = voxelize(surface, {.voxels = 24}).grid;
    const SurfacePoints points = surface_points(grid, surface);
    ASSERT_GT(points.position.rows(), 0) << name;
    // an affine motion of the nodes
    Array<double> x(grid.node_count(), 3);
    for (int64_t n = 0; n < grid.node_count(); ++n)
      for (int d = 0; d < 3; ++d)
        x(n, d) = grid.rest(n, d) + 0.1 * grid.rest(n, (d + 1) % 3) - 0.3 * grid.rest(n, d);
    for (int64_t p = 0; p < points.position.rows(); ++p) {
      const int32_t v = points.voxel(p);
      ASSERT_TRUE(v >= 0 && v < grid.voxel_count());
      // each contact point moves with it
      double moved[3] = {}, rest[3] = {};
      for (int c = 0; c < 8; ++c)
        for (int d = 0; d < 3; ++d) {
          moved[d] += points.weights(p, c) * x(grid.corners(v, c), d);
          rest[d] += points.weights(p, c) * (grid.rest(grid.corners(v, c), d) - grid.rest(0, d));
        }
      const double* X = points.position.row(p);
      for (int d = 0; d < 3; ++d) {
        ASSERT_NEAR(rest[d], X[d] - grid.rest(0, d), 1e-12) << name;
        ASSERT_NEAR(moved[d], X[d] + 0.1 * X[(d + 1) % 3] - 0.3 * X[d], 1e-12) << name;
      }
    }
  }
}

TEST(Slivers, MoveThePointsOnTheirBorderAsTheirNeighboursDo) {
  // a point on the face between a dropped voxel and a kept one moves as the face does
  Fills fills = block({0, 0, 0}, {3, 3, 3});
  fills[{3, 1, 1}] = 0.01;
  ASSERT_EQ(dropped(fills).size(), 1u);
  const VoxelGrid grid = make_box(3, 3, 3, 1);
  Array<double> points(3, 3);
  for (int p = 0; p < 3; ++p)
    for (int d = 0; d < 3; ++d) points(p, d) = d == 0 ? 3 - 1e-12 * (p - 1) : 1.25;
  const Embedding embedding = embed(grid, points);
  for (int p = 0; p < 3; ++p) {
    EXPECT_EQ(embedding.voxel(p), embedding.voxel(0));
    for (int c = 0; c < 8; ++c)
      EXPECT_NEAR(embedding.weights(p, c), (c & 1) * (c & 2 ? 0.25 : 0.75) * (c & 4 ? 0.25 : 0.75),
                  2e-12);
  }
}

TEST(Slivers, RefuseWrongShapesAndPlaces) {
  Array<int32_t> far(1, 3);
  far(0, 1) = 1 << 20;
  EXPECT_THROW(find_slivers(far, Array<double>(1)), Error);
  EXPECT_THROW(find_slivers(Array<int32_t>(2, 2), Array<double>(2)), Error);
  EXPECT_THROW(find_slivers(Array<int32_t>(2, 3), Array<double>(3)), Error);
}

}  // namespace
}  // namespace elastogen
