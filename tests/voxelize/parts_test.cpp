// SPDX-License-Identifier: Apache-2.0
// Pieces that voxels would join: found with their gap, and kept apart where that is asked for.

#include "core/error.hpp"
#include "tests/voxelize/shapes.hpp"
#include "voxelize/embedding.hpp"
#include "voxelize/labels.hpp"
#include "voxelize/triangle_gap.hpp"
#include "voxelize/voxelize.hpp"

#include <random>

namespace elastogen {
namespace {

using test::Soup;

Soup moved(Soup soup, const Vec3& by) {
  for (Vec3& p : soup.vertices) p = plus(p, by);
  return soup;
}

Soup both(Soup a, const Soup& b) {
  a.add(b);
  return a;
}

/// The point of a triangle at barycentric (a, b) that come from a square.
Vec3 point_of(const Vec3 c[3], double a, double b) {
  if (a + b > 1) a = 1 - a, b = 1 - b;
  return plus(c[0], plus(scaled(minus(c[1], c[0]), a), scaled(minus(c[2], c[0]), b)));
}

TEST(Parts, TheGapOfTrianglesIsTheLeastDistanceOfTheirPoints) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> place(-1, 1), share(0, 1);
  int meet = 0;
  for (int k = 0; k < 200; ++k) {
    Vec3 a[3], b[3];
    for (int i = 0; i < 3; ++i)
      for (size_t d = 0; d < 3; ++d)
        a[i][d] = place(engine), b[i][d] = place(engine) + 0.5 * (k % 3);
    const double gap = std::sqrt(triangle_gap2(a, b));
    EXPECT_NEAR(gap, std::sqrt(triangle_gap2(b, a)), 1e-12);
    meet += gap == 0;
    double least = 1e300;
    Vec3 near = {};
    for (int i = 0; i <= 40; ++i)
      for (int j = 0; i + j <= 40; ++j) {
        const Vec3 p = point_of(a, i / 40.0, j / 40.0);
        const double d = std::sqrt(triangle_distance2(b, p));
        if (d < least) least = d, near = p;
      }
    EXPECT_LE(gap, least + 1e-12);
    EXPECT_GE(gap, least - 0.06);  // sampled points are 0.05 of an edge apart
  }
  EXPECT_GT(meet, 10);
  EXPECT_LT(meet, 100);
  // edges that cross at a distance, where no corner is near
  const Vec3 low[3] = {{-1, 0, 0}, {1, 0, 0}, {0, 0, -1}},
             high[3] = {{0, -1, 0.25}, {0, 1, 0.25}, {0, 0, 2}};
  EXPECT_NEAR(triangle_gap2(low, high), 0.0625, 1e-15);
}

TEST(Parts, JoinedPiecesAreSaidWithTheirGapUntilVoxelsPartThem) {
  for (const double turn : {0.0, 0.4})
    for (const double gap : {0.002, 0.01}) {
      Soup pair = both(test::box({-0.1, 0, 0}, {-gap / 2, 0.1, 0.1}),
                       test::box({gap / 2, 0.02, 0.02}, {0.07, 0.09, 0.09}));
      pair.map([&](const Vec3& p) { return test::turned(p, turn); });
      const Surface surface = pair.surface();
      const Voxelized coarse = voxelize(surface, {.h = 0.02});
      EXPECT_EQ(coarse.grid.pieces, 1);
      ASSERT_EQ(coarse.report.gaps.size(), 1u);
      EXPECT_NEAR(coarse.report.gaps[0].distance, gap, 1e-9);
      const auto [a, b] = coarse.report.gaps[0].triangle;
      EXPECT_EQ(std::min(a, b) / 12, 0);
      EXPECT_EQ(std::max(a, b) / 12, 1);
      if (gap < 0.01) continue;
      const Voxelized fine = voxelize(surface, {.h = 0.99 * gap / (2 * std::sqrt(3.0))});
      EXPECT_EQ(fine.grid.pieces, 2);
      EXPECT_TRUE(fine.report.gaps.empty());
    }
}

TEST(Parts, WhatTouchesOverlapsOrLiesWithinIsOnePart) {
  const Soup cube = test::box({0, 0, 0}, {1, 1, 1});
  Soup cavity = test::box({0.02, 0.02, 0.02}, {0.98, 0.98, 0.98});
  for (auto& t : cavity.triangles) std::swap(t[1], t[2]);
  const Soup others[] = {test::box({1, 0.3, 0.3}, {2, 0.6, 0.6}),    // touches
                         test::box({0.9, 0.3, 0.3}, {2, 0.6, 0.6}),  // overlaps
                         test::box({1, 1, 1}, {2, 2, 2}),
                         cavity,                                          // a corner; a wall of 2 %
                         test::box({0.02, 0.02, 0.02}, {0.9, 0.9, 0.9}),  // within
                         test::box({1 + 1e-7, 0, 0}, {2, 1, 1})};         // within the weld
  for (size_t k = 0; k < std::size(others); ++k)
    for (const bool part : {false, true}) {
      const Voxelized v =
          voxelize(both(cube, others[k]).surface(), {.h = 0.1, .part_pieces = part});
      EXPECT_TRUE(v.report.gaps.empty()) << k;
      EXPECT_TRUE(v.part.empty()) << k;
      EXPECT_TRUE(v.grid.part.empty()) << k;
    }
}

TEST(Parts, ASoupBesideABodyIsOnePart) {
  const Soup cube = test::box({0, 0, 0}, {1, 1, 1});
  Soup loose;
  for (const auto& triangle : cube.triangles) {
    const auto first = int(loose.vertices.size());
    for (const int v : triangle)
      loose.vertices.push_back(
          plus(cube.vertices[size_t(v)], {1e-4 * (first % 5), 0, 1e-4 * (v % 3)}));
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_TRUE(voxelize(loose.surface(), {.h = 0.1}).report.gaps.empty());
  const Voxelized v = voxelize(both(moved(loose, {-1.03, 0, 0}), cube).surface(), {.h = 0.1});
  ASSERT_EQ(v.report.gaps.size(), 1u);
  EXPECT_NEAR(v.report.gaps[0].distance, 0.03 - 4e-4, 5e-4);
}

TEST(Parts, KeptApartEachPartHasItsOwnVoxelsAndVolume) {
  // two boxes 0.002 apart, and a ball 0.01 away from both
  const Soup a = test::box({0, 0, 0}, {0.503, 1, 1}), b = test::box({0.505, 0, 0}, {1, 1, 1});
  const Soup c = test::sphere(0.2, {0.5, 0.5, 1.21}, 3);
  const Surface surface = both(both(a, b), c).surface();
  // joined by their voxels
  const Voxelized joined = voxelize(surface, {.h = 0.1});
  EXPECT_EQ(joined.grid.pieces, 1);
  EXPECT_EQ(joined.report.gaps.size(), 3u);
  // kept apart, each with its own voxels
  const Voxelized v = voxelize(surface, {.h = 0.1, .part_pieces = true});
  EXPECT_EQ(v.grid.pieces, 3);
  EXPECT_TRUE(v.report.gaps.empty());
  double volume[3] = {};
  for (int64_t k = 0; k < v.grid.voxel_count(); ++k) {
    volume[v.grid.part(k)] += v.grid.fill(k) * 1e-3;
    const double* lower = v.grid.rest.row(v.grid.corners(k, 0));
    const double* upper = v.grid.rest.row(v.grid.corners(k, 7));
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(upper[d] - lower[d], 0.1, 1e-12);
    const int part = v.grid.part(k);
    EXPECT_TRUE(part == 2 || (part == 0 ? lower[0] < 0.503 : upper[0] > 0.505));
    for (int n = 0; n < 8; ++n)
      EXPECT_EQ(v.grid.piece(v.grid.corners(k, n)), v.grid.piece(v.grid.corners(k, 0)));
  }
  EXPECT_NEAR(volume[0], 0.503, 1e-3);  // slivers of 0.0135 go
  EXPECT_NEAR(volume[1], 0.495, 1e-3);
  EXPECT_NEAR(volume[2], c.volume(), 0.02 * c.volume());
}

TEST(Parts, PointsAndMaterialsGoWithTheirOwnPart) {
  const Soup a = test::box({0, 0, 0}, {0.503, 1, 1}), b = test::box({0.505, 0, 0}, {1, 1, 1});
  Body body;
  body.surface = both(a, b).surface();
  body.carried = body.surface.vertices;
  Voxelized v = voxelize(body.surface, {.h = 0.1, .part_pieces = true});
  body.surface.part = v.part;
  const Array<int32_t> part = parts_of_carried(body);
  for (int64_t p = 0; p < 16; ++p) EXPECT_EQ(part(p), p / 8);
  Array<double> x = v.grid.rest;
  for (int64_t k = 0; k < v.grid.voxel_count(); ++k)
    for (int c = 0; c < 8; ++c)
      if (v.grid.part(k) == 1)
        x(v.grid.corners(k, c), 1) = v.grid.rest(v.grid.corners(k, c), 1) + 2;
  Array<double> displacement(16, 3);
  deform_asset(v.grid, embed(v.grid, body.carried, part), x, displacement);
  const Array<int32_t> nearest = nearest_triangles(v.grid, body.surface);
  for (int64_t p = 0; p < 16; ++p) EXPECT_NEAR(displacement(p, 1), p < 8 ? 0 : 2, 1e-12);
  for (int64_t k = 0; k < v.grid.voxel_count(); ++k) EXPECT_EQ(nearest(k) / 12, v.grid.part(k));
  // contact points too
  const SurfacePoints points = surface_points(v.grid, body.surface);
  for (int64_t p = 0; p < points.position.rows(); ++p)
    EXPECT_EQ(v.grid.part(points.voxel(p)), points.position(p, 0) > 0.504);
  // points of a cloud go with the nearest surface
  body.is_asset = false;
  body.carried = Array<double>(2, 3);
  body.carried(0, 0) = 0.5035, body.carried(1, 0) = 0.5045;
  for (int64_t p = 0; p < 2; ++p) body.carried(p, 1) = body.carried(p, 2) = 0.5;
  const Array<int32_t> of_cloud = parts_of_carried(body);
  EXPECT_EQ(of_cloud(0), 0);
  EXPECT_EQ(of_cloud(1), 1);
  EXPECT_THROW(embed(v.grid, body.carried), Error);
}

}  // namespace
}  // namespace elastogen
