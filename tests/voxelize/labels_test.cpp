// SPDX-License-Identifier: Apache-2.0
#include "voxelize/labels.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/voxelize/shapes.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// Squared distance to a triangle by the nearest of many of its points.
double sampled_distance2(const Vec3 c[3], const Vec3& p, int n) {
  double least = 1e300;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) {
      const double a = double(i) / n, b = double(j) / n;
      const Vec3 x = plus(plus(scaled(c[0], 1 - a - b), scaled(c[1], a)), scaled(c[2], b));
      least = std::min(least, dot(minus(p, x), minus(p, x)));
    }
  return least;
}

TEST(Labels, DistanceFromATriangleIsThatOfItsNearestPoint) {
  const Vec3 c[3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  EXPECT_NEAR(triangle_distance2(c, {0.3, 0.3, -2}), 4, 1e-15);  // over its inside
  EXPECT_NEAR(triangle_distance2(c, {1, -3, 4}), 25, 1e-14);     // over an edge
  EXPECT_NEAR(triangle_distance2(c, {5, -4, 0}), 25, 1e-14);     // beyond a corner
  const Vec3 flat[3] = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}};        // without area
  EXPECT_NEAR(triangle_distance2(flat, {2, 2, 0}), 4, 1e-15);
  const Vec3 skew[3] = {{0.1, 0.2, 0.3}, {1.3, -0.4, 0.6}, {0.5, 0.9, -0.7}};
  for (const Vec3& p : {Vec3{0.4, 0.1, 0.9}, {-1, 0.3, 0.2}, {2, 1, 1}, {0.6, 0.2, 0.1}})
    EXPECT_NEAR(triangle_distance2(skew, p), sampled_distance2(skew, p, 600), 1e-2);
}

TEST(Labels, AreThoseOfASearchThroughAllTriangles) {
  Soup soup = sphere(0.4, {0, 0, 0}, 3);
  soup.add(sphere(0.2, {0.5, 0.1, 0}, 2));
  const Surface surface = soup.surface();
  const VoxelGrid grid = voxelize(surface, {.h = 0.05}).grid;
  const Array<int32_t> nearest = nearest_triangles(grid, surface);
  ASSERT_EQ(nearest.rows(), grid.voxel_count());
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    Vec3 centre;
    for (int d = 0; d < 3; ++d) centre[size_t(d)] = grid.rest(grid.corners(v, 0), d) + grid.h / 2;
    const auto distance2 = [&](int64_t t) {
      Vec3 c[3];
      for (int k = 0; k < 3; ++k)
        for (int d = 0; d < 3; ++d) c[k][size_t(d)] = surface.vertices(surface.triangles(t, k), d);
      return triangle_distance2(c, centre);
    };
    double least = 1e300;
    for (int64_t t = 0; t < surface.triangles.rows(); ++t) least = std::min(least, distance2(t));
    EXPECT_LE(distance2(nearest(v)), least * (1 + 2e-6)) << "voxel " << v;
  }
}

TEST(Labels, VoxelsOfTouchingSolidsGoWithTheirOwn) {
  // both have a face at x = 0, as near to the voxels on both sides
  Soup soup = box({-0.4, 0, 0}, {0, 0.4, 0.4});
  soup.add(box({0, 0, 0}, {0.4, 0.4, 0.4}));
  const Surface surface = soup.surface();
  const VoxelGrid grid = make_box(8, 4, 4, 0.1, {-0.4, 0, 0});
  const Array<int32_t> nearest = nearest_triangles(grid, surface);
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    EXPECT_EQ(nearest(v) >= 12, grid.voxel_coord(v, 0) >= 4) << "voxel " << v;
}

TEST(Labels, AreTheSameOnOneThread) {
  const Surface surface = sphere(0.4, {0, 0, 0}, 3).surface();
  const VoxelGrid grid = voxelize(surface, {.h = 0.05}).grid;
  const Array<int32_t> all = nearest_triangles(grid, surface);
  const ThreadLimit limit(1);
  EXPECT_EQ(nearest_triangles(grid, surface), all);
}

TEST(Labels, ASurfaceWithoutTrianglesIsRejected) {
  EXPECT_THROW(nearest_triangles(make_box(1, 1, 1, 1), Surface{}), Error);
}

}  // namespace
}  // namespace elastogen::test
