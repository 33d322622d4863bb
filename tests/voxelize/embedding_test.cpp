// SPDX-License-Identifier: Apache-2.0
#include "voxelize/embedding.hpp"

#include "core/bricks/index.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/voxelize/shapes.hpp"
#include "voxelize/bricks.hpp"
#include "voxelize/nearest_voxel.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace elastogen {
namespace {

using namespace test;

Array<double> random_points(int64_t count, double lower, double upper, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(lower, upper);
  Array<double> points(count, 3);
  for (int64_t i = 0; i < points.size(); ++i) points.data()[i] = place(random);
  return points;
}

/// Points up to `margin` voxels outside of the box of a grid.
Array<double> points_around(const VoxelGrid& grid, int64_t count, double margin, unsigned seed) {
  Box box;
  for (int64_t n = 0; n < grid.node_count(); ++n)
    box.add({grid.rest(n, 0), grid.rest(n, 1), grid.rest(n, 2)});
  Array<double> points = random_points(count, 0, 1, seed);
  for (int64_t p = 0; p < count; ++p)
    for (int d = 0; d < 3; ++d) {
      const double low = box.lower[d] - margin * grid.h, high = box.upper[d] + margin * grid.h;
      points(p, d) = low + points(p, d) * (high - low);
    }
  return points;
}

double largest_row(const Array<double>& a, const Array<double>* minus = nullptr) {
  double largest = 0;
  for (int64_t n = 0; n < a.rows(); ++n) {
    double square = 0;
    for (int d = 0; d < 3; ++d) square += std::pow(a(n, d) - (minus ? (*minus)(n, d) : 0), 2);
    largest = std::max(largest, std::sqrt(square));
  }
  return largest;
}

/// An affine map with stretch, shear and rotation.
Vec3 affine(const double* p) {
  return {0.3 + 1.1 * p[0] - 0.4 * p[1] + 0.2 * p[2], -1 + 0.5 * p[0] + 0.9 * p[1],
          2 - 0.1 * p[0] + 0.3 * p[1] + 1.2 * p[2]};
}

TEST(Embedding, CarriesAffineFieldsInsideAndOutsideOfTheGrid) {
  const VoxelGrid grid = make_box(5, 9, 12, 0.2, {-0.1, 0.2, 0.3});
  const Array<double> points = points_around(grid, 500, 0.999, 1);
  Array<double> x(grid.node_count(), 3), displacement(points.rows(), 3);
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    const Vec3 moved = affine(grid.rest.row(n));
    std::copy(moved.begin(), moved.end(), x.row(n));
  }
  deform_asset(grid, embed(grid, points), x, displacement);
  for (int64_t p = 0; p < points.rows(); ++p)
    for (int d = 0; d < 3; ++d)
      ASSERT_NEAR(points(p, d) + displacement(p, d), affine(points.row(p))[d], 1e-12);
}

TEST(Embedding, GradientOfAnAffineFieldIsItsMatrix) {
  const VoxelGrid grid = make_box(5, 9, 12, 0.2, {-0.1, 0.2, 0.3});
  const Array<double> points = points_around(grid, 500, 0.999, 2);
  Array<double> x(grid.node_count(), 3), gradient(points.rows(), 9);
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    const Vec3 moved = affine(grid.rest.row(n));
    std::copy(moved.begin(), moved.end(), x.row(n));
  }
  deformation_gradient(grid, embed(grid, points), x, gradient);
  const double expected[9] = {1.1, -0.4, 0.2, 0.5, 0.9, 0, -0.1, 0.3, 1.2};
  for (int64_t p = 0; p < points.rows(); ++p)
    for (int k = 0; k < 9; ++k) ASSERT_NEAR(gradient(p, k), expected[k], 1e-11);

  deformation_gradient(grid, embed(grid, points), grid.rest, gradient);
  for (int64_t p = 0; p < points.rows(); ++p)
    for (int k = 0; k < 9; ++k) ASSERT_EQ(gradient(p, k), k % 4 == 0 ? 1 : 0);
}

TEST(Embedding, GradientIsTheDerivativeOfThePlaces) {
  const VoxelGrid grid = make_box(3, 4, 5, 0.25, {0, 0, 0});
  Array<double> x = grid.rest;
  const Array<double> noise = random_points(grid.node_count(), -0.1, 0.1, 5);
  for (int64_t k = 0; k < x.size(); ++k) x.data()[k] += noise.data()[k];
  const Array<double> points = points_around(grid, 200, 0.99, 6);
  Array<double> gradient(points.rows(), 9);
  deformation_gradient(grid, embed(grid, points), x, gradient);
  const double step = 1e-5;
  for (int d = 0; d < 3; ++d) {
    Array<double> moved[2] = {points, points}, at[2];
    for (int s = 0; s < 2; ++s) {
      for (int64_t p = 0; p < points.rows(); ++p) moved[s](p, d) += s ? step : -step;
      at[s] = Array<double>(points.rows(), 3);
      deform_asset(grid, embed(grid, moved[s]), x, at[s]);
    }
    for (int64_t p = 0; p < points.rows(); ++p)
      for (int i = 0; i < 3; ++i)
        ASSERT_NEAR(gradient(p, 3 * i + d),
                    (at[1](p, i) - at[0](p, i)) / (2 * step) + (i == d ? 1 : 0), 1e-8);
  }
}

/// Places of the nodes of a body under a motion.
template <class Motion>
Array<double> moved_nodes(const VoxelGrid& grid, const Motion& motion) {
  Array<double> x(grid.node_count(), 3);
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    const Vec3 place = motion(Vec3{grid.rest(n, 0), grid.rest(n, 1), grid.rest(n, 2)});
    std::copy(place.begin(), place.end(), x.row(n));
  }
  return x;
}

/// Quarter turn about z, and a bar bent to a quarter of a circle of length 12.
Vec3 quarter_turn(const Vec3& p) {
  return {-p[1], p[0], p[2]};
}
Vec3 bent(const Vec3& p) {
  const double radius = 24 / std::numbers::pi, angle = p[0] / radius, r = radius - p[1];
  return {r * std::sin(angle), radius - r * std::cos(angle), p[2]};
}

TEST(Embedding, StraysMoveNoFartherThanTheFarthestNode) {
  const VoxelGrid grid = make_box(12, 3, 3, 1, {0, -1.5, -1.5});
  const double length = 12;
  const auto shifted = [](const Vec3& p) { return Vec3{p[0] + 3, p[1] - 4, p[2] + 12}; };
  for (const Array<double>& x :
       {moved_nodes(grid, shifted), moved_nodes(grid, quarter_turn), moved_nodes(grid, bent)}) {
    const double farthest = largest_row(x, &grid.rest);
    for (const double lengths : {0.5, 1., 3., 10., 100.}) {
      Array<double> points = random_points(300, -1, 1, 7), displacement(300, 3);
      for (int64_t p = 0; p < 300; ++p) {  // on a cube around the body, that far from it
        const int axis = int(p % 3);
        const double reach = 6 + lengths * length;
        for (int d = 0; d < 3; ++d)
          points(p, d) =
              (d == 0 ? 6 : 0) + reach * (d == axis ? (points(p, d) < 0 ? -1 : 1) : points(p, d));
      }
      deform_asset(grid, embed(grid, points), x, displacement);
      ASSERT_LE(largest_row(displacement), farthest * (1 + 1e-12)) << lengths;
    }
  }
}

TEST(Embedding, StraysMoveAsTheNearestPointAndTurnWithIt) {
  const VoxelGrid grid = make_box(12, 3, 3, 1, {0, -1.5, -1.5});
  Array<double> points(2, 3), displacement(2, 3), gradient(2, 9);
  points(0, 0) = 5.25, points(0, 1) = 40;
  points(1, 0) = 5.25, points(1, 1) = 1.5;  // the nearest point of the body
  const Embedding embedding = embed(grid, points);
  const Array<double> x = moved_nodes(grid, quarter_turn);
  deform_asset(grid, embedding, x, displacement);
  deformation_gradient(grid, embedding, x, gradient);
  const double turn[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(displacement(0, d), displacement(1, d), 1e-13);
  EXPECT_NEAR(displacement(0, 0), -1.5 - 5.25, 1e-13);
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(gradient(0, k), turn[k], 1e-13);
}

TEST(Embedding, IsContinuousInTheDistance) {
  const VoxelGrid grid = make_box(4, 4, 4, 0.5, {});
  const Array<double> x = moved_nodes(grid, quarter_turn);
  const int64_t steps = 4000;
  Array<double> points(steps, 3), displacement(steps, 3);
  for (int64_t p = 0; p < steps; ++p) {  // 0 to 4 voxels out, at an angle
    points(p, 0) = 2 + 2.0 * double(p) / double(steps);
    points(p, 1) = 2 + 1.1 * double(p) / double(steps);
    points(p, 2) = 0.7;
  }
  deform_asset(grid, embed(grid, points), x, displacement);
  for (int64_t p = 1; p < steps; ++p)
    for (int d = 0; d < 3; ++d)  // of a turn |F - I| < 2, and the fade is twice as steep at most
      ASSERT_NEAR(displacement(p, d), displacement(p - 1, d), 8 * 2.0 / double(steps));
}

TEST(Embedding, GradientRefusesWrongShapes) {
  const VoxelGrid grid = make_box(1, 1, 1, 1, {0, 0, 0});
  const Embedding embedding = embed(grid, random_points(3, 0, 1, 1));
  Array<double> good(3, 9), bad(3, 3);
  EXPECT_THROW(deformation_gradient(grid, embedding, grid.rest, bad), Error);
  EXPECT_THROW(deformation_gradient(grid, embedding, bad, good), Error);
}

TEST(Embedding, LeavesARestingAssetWhereItIsToTheBit) {
  const Soup soup = sphere(1, {3, 1, 4}, 4);
  const Surface surface = soup.surface();
  const VoxelGrid grid = voxelize(surface, {.voxels = 20}).grid;
  Array<double> displacement(surface.vertices.rows(), 3);
  displacement.fill(1);
  deform_asset(grid, embed(grid, surface.vertices), grid.rest, displacement);
  for (int64_t i = 0; i < displacement.size(); ++i) {
    ASSERT_EQ(displacement.data()[i], 0);
    ASSERT_EQ(surface.vertices.data()[i] + displacement.data()[i], surface.vertices.data()[i]);
  }
}

TEST(Embedding, APartWithoutVoxelsRests) {
  const Surface surface = sphere(1, {}, 4).surface();
  VoxelGrid grid = voxelize(surface, {.voxels = 10}).grid;
  grid.part = Array<int32_t>(grid.voxel_count());
  grid.part_shift = {0, 0};
  Array<double> points(2, 3), x = grid.rest, displacement(2, 3);
  Array<int32_t> part(2);
  part(1) = 1;
  for (int64_t n = 0; n < x.rows(); ++n) x(n, 1) += 3;
  const Embedding embedding = embed(grid, points, part);
  deform_asset(grid, embedding, x, displacement);
  EXPECT_NEAR(displacement(0, 1), 3, 1e-12);
  EXPECT_EQ(displacement(1, 1), 0);
  EXPECT_GE(embedding.voxel(1), 0);
}

TEST(Embedding, PutsEachPointIntoTheVoxelThatHoldsIt) {
  const Soup soup = sphere(1, {}, 4);
  const Surface surface = soup.surface();
  const VoxelGrid grid = voxelize(surface, {.voxels = 20}).grid;
  const BrickIndex index(grid.voxel_coord);
  const Embedding embedding = embed(grid, surface.vertices);
  for (int64_t p = 0; p < surface.vertices.rows(); ++p) {
    // the cell of each vertex; a dropped sliver has no voxel
    Coord cell;
    for (int d = 0; d < 3; ++d)
      cell[d] =
          static_cast<int32_t>(std::floor((surface.vertices(p, d) - grid.origin[d]) / grid.h));
    const bool held = index.find(cell) >= 0;
    // weights sum to 1 and give back the place
    double sum = 0;
    Vec3 place = {};
    for (int c = 0; c < 8; ++c) {
      const double w = embedding.weights(p, c);
      ASSERT_GE(w, held ? -1e-4 : -1);
      sum += w;
      const double* corner = grid.rest.row(grid.corners(embedding.voxel(p), c));
      place = plus(place, scaled({corner[0], corner[1], corner[2]}, w));
    }
    ASSERT_NEAR(sum, 1, 1e-14);
    for (int d = 0; d < 3; ++d) ASSERT_NEAR(place[d], surface.vertices(p, d), 1e-13);
  }
}

TEST(Embedding, FindsTheNearestVoxelAsASearchOverAllDoes) {
  // random voxels, most of them isolated
  std::mt19937 random(5);
  std::uniform_int_distribution<int> place(-60, 60);
  std::vector<std::array<int, 3>> chosen;
  for (int i = 0; i < 300; ++i) chosen.push_back({place(random), place(random), place(random)});
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  Array<int32_t> coords(static_cast<int64_t>(chosen.size()), 3);
  for (int64_t v = 0; v < coords.rows(); ++v)
    for (int d = 0; d < 3; ++d) coords(v, d) = chosen[v][d];
  const VoxelGrid grid = make_grid(coords, 1, {});
  const NearestVoxel nearest(grid.voxel_coord);
  // points in and around them
  const Array<double> points = random_points(400, -150, 150, 6);
  for (int64_t p = 0; p < points.rows(); ++p) {
    const auto distance = [&](int64_t v) {
      double sum = 0;
      for (int d = 0; d < 3; ++d) {
        const double t = points(p, d) - grid.voxel_coord(v, d);
        sum += std::pow(t - std::clamp(t, 0.0, 1.0), 2);
      }
      return sum;
    };
    double least = 1e300;
    for (int64_t v = 0; v < grid.voxel_count(); ++v) least = std::min(least, distance(v));
    ASSERT_EQ(distance(nearest.find({points(p, 0), points(p, 1), points(p, 2)})), least);
  }
}

TEST(Embedding, PlacesPointsHoweverFarAway) {
  const VoxelGrid grid = make_box(2, 2, 2, 1e-6, {});
  Array<double> points(2, 3);
  points(0, 0) = 1e12;
  points(1, 2) = -1e300;
  const Embedding embedding = embed(grid, points);
  EXPECT_EQ(grid.voxel_coord(embedding.voxel(0), 0), 1);
  EXPECT_EQ(grid.voxel_coord(embedding.voxel(1), 2), 0);
}

TEST(Embedding, ThreadsDoNotChangeABit) {
  const VoxelGrid grid = make_box(9, 9, 9, 0.1, {});
  const Array<double> points = random_points(5000, -0.1, 1, 2);
  const Array<double> x = random_points(grid.node_count(), 0, 1, 3);
  Array<double> displacement[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit control(threads);
    displacement[threads - 1] = Array<double>(points.rows(), 3);
    deform_asset(grid, embed(grid, points), x, displacement[threads - 1]);
  }
  EXPECT_TRUE(displacement[0] == displacement[1]);
}

TEST(Embedding, RefusesWrongShapesAndNonFinitePoints) {
  const VoxelGrid grid = make_box(1, 1, 1, 1);
  Array<double> points(1, 3), x(8, 3), wrong(7, 3);
  EXPECT_THROW(embed(grid, Array<double>(4, 2)), Error);
  const Embedding embedding = embed(grid, points);
  EXPECT_THROW(deform_asset(grid, embedding, wrong, points), Error);
  EXPECT_THROW(deform_asset(grid, embedding, x, wrong), Error);
  points(0, 1) = std::nan("");
  EXPECT_THROW(embed(grid, points), Error);
}

TEST(SurfacePoints, ShareOutTheAreaOfTheSurface) {
  for (const Soup& soup : {box({0, 0, 0}, {1, 0.7, 0.4}), sphere(1, {}, 4), sheet(1, 3)}) {
    const Surface surface = soup.surface();
    const VoxelGrid grid = voxelize(surface, {.voxels = 16}).grid;
    const SurfacePoints points = surface_points(grid, surface);
    double area = 0;
    for (int64_t p = 0; p < points.area.rows(); ++p) {
      ASSERT_GT(points.area(p), 0);
      area += points.area(p);
    }
    EXPECT_NEAR(area, soup.area(), 1e-12 * soup.area());
  }
}

TEST(SurfacePoints, AreTheVerticesWhereTrianglesAreSmall) {
  const Soup soup = sphere(1, {}, 4);
  const SurfacePoints points =
      surface_points(voxelize(soup.surface(), {.voxels = 10}).grid, soup.surface());
  ASSERT_EQ(points.position.rows(), static_cast<int64_t>(soup.vertices.size()));
  for (int64_t p = 0; p < points.position.rows(); ++p)
    for (int d = 0; d < 3; ++d) ASSERT_EQ(points.position(p, d), soup.vertices[p][d]);
}

TEST(SurfacePoints, LieHalfAnEdgeApartOnLargeTriangles) {
  const Soup soup = box({0, 0, 0}, {1, 1, 1});
  const VoxelGrid grid = voxelize(soup.surface(), {.voxels = 8}).grid;
  const SurfacePoints points = surface_points(grid, soup.surface());
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    Vec3 p = {place(random), place(random), place(random)};
    p[trial % 3] = trial % 2;
    double nearest = 1;
    for (int64_t i = 0; i < points.position.rows(); ++i) {
      const double* q = points.position.row(i);
      nearest = std::min(nearest, norm(minus(p, {q[0], q[1], q[2]})));
    }
    ASSERT_LE(nearest, grid.h / 2);
  }
  // on the surface, each carried by its voxel's weights
  for (int64_t i = 0; i < points.position.rows(); ++i) {
    double sum = 0, outside = 1;
    for (int c = 0; c < 8; ++c) sum += points.weights(i, c);
    for (int d = 0; d < 3; ++d)
      outside = std::min({outside, points.position(i, d), 1 - points.position(i, d)});
    ASSERT_NEAR(sum, 1, 1e-14);
    ASSERT_NEAR(outside, 0, 1e-15);
  }
}

}  // namespace
}  // namespace elastogen
