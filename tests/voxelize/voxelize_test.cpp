// SPDX-License-Identifier: Apache-2.0
#include "voxelize/voxelize.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/voxelize/shapes.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <random>

namespace elastogen {
namespace {

using namespace test;

/// Lower and upper end of an interval within the cell of a coordinate, in units of the cell.
std::pair<double, double> overlap(double lower, double upper, double origin, double h, int i) {
  return {std::clamp((lower - origin) / h - i, 0.0, 1.0),
          std::clamp((upper - origin) / h - i, 0.0, 1.0)};
}

TEST(Voxelize, FillAndMeansOfABoxAreTheProductsOfItsOverlaps) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> offset(0.3, 0.7);
  for (int trial = 0; trial < 20; ++trial) {
    // a random box on a random lattice
    const Vec3 lower = {offset(random), -offset(random), 3 * offset(random)};
    const Vec3 upper = plus(lower, {1, 0.35 + offset(random), 0.8});
    VoxelizeOptions options = {.h = 0.1 * (0.8 + offset(random))};
    for (int d = 0; d < 3; ++d) options.align[d] = lower[d] + options.h * offset(random);
    const VoxelGrid grid = voxelize(box(lower, upper).surface(), options).grid;
    for (int64_t v = 0; v < grid.voxel_count(); ++v) {
      // overlap of each voxel with the box, axis by axis
      double fill = 1, mean[3];
      for (int d = 0; d < 3; ++d) {
        const auto [a, b] =
            overlap(lower[d], upper[d], grid.origin[d], grid.h, grid.voxel_coord(v, d));
        fill *= b - a;
        mean[d] = (a + b) / 2;
      }
      ASSERT_NEAR(grid.fill(v), std::max(fill, 0.02), 1e-12);
      for (int c = 0; c < 8; ++c) {
        double expected = 1;
        for (int d = 0; d < 3; ++d) expected *= c >> d & 1 ? mean[d] : 1 - mean[d];
        ASSERT_NEAR(grid.shape_mean(v, c), expected, 1e-9);
      }
    }
    EXPECT_NEAR(grid.volume, box(lower, upper).volume(), 1e-12);
  }
}

TEST(Voxelize, ABoxFlushWithTheLatticeIsAFullBlock) {
  for (const double shift : {0.0, 0.1, 1e3, -1e5}) {
    Soup soup = box({shift, shift, shift}, {shift + 1, shift + 0.5, shift + 0.25});
    const Voxelized result = voxelize(soup.surface(), {.voxels = 32});
    EXPECT_EQ(result.grid.voxel_count(), 32 * 16 * 8);
    EXPECT_EQ(result.report.thin_voxels, 0);
    for (int64_t v = 0; v < result.grid.voxel_count(); ++v) {
      ASSERT_EQ(result.grid.fill(v), 1);
      for (int c = 0; c < 8; ++c) ASSERT_EQ(result.grid.shape_mean(v, c), 0.125);
    }
  }
}

TEST(Voxelize, ADiagonalCutHasTheMomentsOfATriangle) {
  // prism x, y >= 0, x + y <= 1: the voxels with i + j = 7 are cut along their diagonal
  Soup prism;
  prism.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  prism.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3},
                     {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
  const VoxelGrid grid = voxelize(prism.surface(), {.voxels = 8}).grid;
  const double moment[4] = {5.0 / 24, 1.0 / 8, 1.0 / 8, 1.0 / 24};
  int64_t cut = 0;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    const bool diagonal = grid.voxel_coord(v, 0) + grid.voxel_coord(v, 1) == 7;
    cut += diagonal;
    ASSERT_NEAR(grid.fill(v), diagonal ? 0.5 : 1, 1e-13);
    for (int c = 0; c < 8; ++c)
      ASSERT_NEAR(grid.shape_mean(v, c), diagonal ? moment[c & 3] : 0.125, 1e-13);
  }
  EXPECT_EQ(cut, 64);
  EXPECT_NEAR(grid.volume, 0.5, 1e-14);
}

TEST(Voxelize, FillOfASphereAgreesWithSamples) {
  const Vec3 centre = {0.3, -0.2, 5};
  const VoxelGrid grid = voxelize(sphere(1, centre, 6).surface(), {.voxels = 13}).grid;
  constexpr int kSamples = 24;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    // samples in each voxel
    int inside = 0;
    Vec3 sum = {};
    for (int s = 0; s < kSamples * kSamples * kSamples; ++s) {
      const int index[3] = {s % kSamples, s / kSamples % kSamples, s / kSamples / kSamples};
      Vec3 t, p;
      for (int d = 0; d < 3; ++d) {
        t[d] = (index[d] + 0.5) / kSamples;
        p[d] = grid.origin[d] + grid.h * (grid.voxel_coord(v, d) + t[d]) - centre[d];
      }
      if (norm(p) > 1) continue;
      ++inside;
      sum = plus(sum, t);
    }
    // fill, and the centroid if there is enough of it
    const double fill = inside / std::pow(kSamples, 3);
    ASSERT_NEAR(grid.fill(v), std::max(fill, 0.02), 0.01);
    if (fill < 0.1) continue;
    for (int d = 0; d < 3; ++d) {
      double middle = 0;
      for (int c = 0; c < 8; ++c) middle += grid.shape_mean(v, c) * (c >> d & 1);
      ASSERT_NEAR(middle, sum[d] / inside, 0.02);
    }
  }
}

TEST(Voxelize, MassCentreAndInertiaOfASphereConvergeWithTheSquareOfTheEdge) {
  const Vec3 centre = {0.1, 0.2, 0.3};
  const Soup soup = sphere(1, centre, 6);
  double error[2];
  for (int level = 0; level < 2; ++level) {
    const VoxelGrid grid = voxelize(soup.surface(), {.voxels = 16 << level}).grid;
    EXPECT_NEAR(grid.volume, soup.volume(), 1e-12);
    // sums over corners, each with its share of the mass
    double total = 0, inertia = 0;
    Vec3 first = {};
    for (int64_t v = 0; v < grid.voxel_count(); ++v)
      for (int c = 0; c < 8; ++c) {
        const double m = grid.fill(v) * grid.shape_mean(v, c) * std::pow(grid.h, 3);
        Vec3 r;
        for (int d = 0; d < 3; ++d) r[d] = grid.rest(grid.corners(v, c), d) - centre[d];
        total += m;
        inertia += m * (r[0] * r[0] + r[1] * r[1]);
        first = plus(first, scaled(r, m));
      }
    EXPECT_LT(norm(first) / total, 1e-12);
    // the inertia of a ball is 2/5 m r^2; its error falls fourfold
    error[level] = inertia / (0.4 * total) - 1;
    std::printf("sphere of %d voxels: mass %+.2e, inertia %+.2e\n", 16 << level,
                total / soup.volume() - 1, error[level]);
    EXPECT_LT(std::abs(total / soup.volume() - 1), 0.02 * std::pow(0.5, level));
  }
  EXPECT_LT(std::abs(error[0]), 0.02);
  EXPECT_NEAR(error[0] / error[1], 4, 0.8);
}

TEST(Voxelize, EveryVertexLiesInAnActiveVoxelOrNextToOneInASliver) {
  Soup soup = sphere(1, {}, 4);
  soup.add(box({0.9, -0.02, -0.02}, {2.5, 0.02, 0.02}));
  const VoxelGrid grid = voxelize(soup.surface(), {.voxels = 40}).grid;
  int64_t outside = 0;
  for (const Vec3& p : soup.vertices) {
    double nearest = 1e300;  // largest coordinate difference, in edges
    for (int64_t v = 0; v < grid.voxel_count(); ++v) {
      double gap = 0;
      for (int d = 0; d < 3; ++d) {
        const double t = (p[d] - grid.origin[d]) / grid.h - grid.voxel_coord(v, d);
        gap = std::max({gap, -t, t - 1});
      }
      nearest = std::min(nearest, gap);
    }
    outside += nearest > 2e-5;
    ASSERT_LT(nearest, 1) << p[0] << ' ' << p[1] << ' ' << p[2];
  }
  EXPECT_LT(outside, static_cast<int64_t>(soup.vertices.size()) / 20);
}

TEST(Voxelize, APlateATenthOfAVoxelThickStaysInOnePiece) {
  for (const double angle : {0.0, 0.3, 0.8, 2.1}) {
    Soup soup = box({0, 0, 0}, {1, 1, 1.0 / 320});
    soup.map([&](const Vec3& p) { return turned(p, angle); });
    const Voxelized result = voxelize(soup.surface(), {.h = 1.0 / 32});
    EXPECT_EQ(result.grid.pieces, 1) << angle;
    EXPECT_FALSE(has_finding(result.report, "hinges")) << angle;
    EXPECT_NEAR(result.grid.volume, 1.0 / 320, 1e-12);
    EXPECT_NEAR(mass(result.grid) / result.grid.volume, 1, 0.1);
    expect_means(result.grid);
  }
}

TEST(Voxelize, ASheetBecomesALayerOfFullVoxels) {
  Soup flat = sheet(1, 4);
  for (const bool in_lattice_plane : {false, true}) {
    VoxelizeOptions options = {.voxels = 20};
    if (in_lattice_plane) options.align[2] = 0;
    const Voxelized result = voxelize(flat.surface(), options);
    EXPECT_EQ(result.grid.voxel_count(), 400);
    EXPECT_EQ(result.grid.volume, 0);
    EXPECT_FALSE(result.report.closed);
    EXPECT_TRUE(has_finding(result.report, "sheet"));
    for (int64_t v = 0; v < 400; ++v) ASSERT_EQ(result.grid.fill(v), 1);
  }
  flat.map([](const Vec3& p) { return Vec3{p[0], p[1], 0.1 * std::sin(6 * p[0])}; });
  const Voxelized wavy = voxelize(flat.surface(), {.voxels = 30});
  EXPECT_EQ(wavy.grid.pieces, 1);
  EXPECT_EQ(wavy.grid.volume, 0);
}

TEST(Voxelize, AFoldedSheetIsNotFilled) {
  // rolled up to nine tenths of a tube, half of it with the opposite winding
  Soup cloth = sheet(1, 40);
  cloth.map([](const Vec3& p) {
    const double angle = 1.8 * M_PI * p[0];
    return Vec3{0.2 * std::cos(angle), 0.2 * std::sin(angle), p[1]};
  });
  for (size_t t = 0; t < cloth.triangles.size() / 2; ++t) cloth.turn(t);
  const Voxelized result = voxelize(cloth.surface(), {.voxels = 40});
  EXPECT_EQ(result.grid.volume, 0);
  for (int64_t v = 0; v < result.grid.voxel_count(); ++v) {
    Vec3 centre;
    for (int d = 0; d < 3; ++d)
      centre[d] = result.grid.rest(result.grid.corners(v, 0), d) + result.grid.h / 2;
    ASSERT_GT(std::hypot(centre[0], centre[1]), 0.2 - 2 * result.grid.h);
  }
}

TEST(Voxelize, ADoubledSheetIsASheet) {
  Soup soup = sheet(1, 5), back = soup;
  for (size_t t = 0; t < back.triangles.size(); ++t) back.turn(t);
  soup.add(back);
  const Voxelized result = voxelize(soup.surface(), {.voxels = 20});
  EXPECT_EQ(result.grid.voxel_count(), 400);
  EXPECT_TRUE(has_finding(result.report, "sheet"));
}

TEST(Voxelize, WindingDuplicatesAndWeldsDoNotChangeTheGrid) {
  const Soup plain = sphere(1, {0.2, 0.1, 0}, 4);
  const Voxelized expected = voxelize(plain.surface(), {.voxels = 24});
  ASSERT_TRUE(expected.report.closed);
  ASSERT_FALSE(expected.report.winding_number);
  Soup flipped = plain, mixed = plain, doubled = plain, loose;
  for (size_t t = 0; t < plain.triangles.size(); ++t) {
    flipped.turn(t);
    if (t % 7 < 2) mixed.turn(t);
    if (t % 5 == 0) doubled.triangles.push_back(plain.triangles[t]);
    if (t % 10 == 0) doubled.turn(doubled.triangles.size() - 1);
    const int first = static_cast<int>(loose.vertices.size());
    for (const int v : plain.triangles[t]) loose.vertices.push_back(plain.vertices[v]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  expect_same(voxelize(mixed.surface(), {.voxels = 24}).grid, expected.grid);
  expect_same(voxelize(doubled.surface(), {.voxels = 24}).grid, expected.grid);
  expect_same(voxelize(loose.surface(), {.voxels = 24}).grid, expected.grid);
  const VoxelGrid inside_out = voxelize(flipped.surface(), {.voxels = 24}).grid;
  ASSERT_TRUE(inside_out.voxel_coord == expected.grid.voxel_coord);
  for (int64_t v = 0; v < inside_out.voxel_count(); ++v)
    ASSERT_NEAR(inside_out.fill(v), expected.grid.fill(v), 1e-14);
}

TEST(Voxelize, TheWindingNumberAgreesWithTheExactFillAwayFromAHole) {
  const Soup whole = sphere(1, {0.01, 0.02, 0.03}, 5);
  Soup open = whole;
  const Vec3 hole = open.vertices[open.triangles.back()[0]];
  open.triangles.pop_back();
  const VoxelizeOptions options = {.voxels = 24};
  const VoxelGrid exact = voxelize(whole.surface(), options).grid;
  const Voxelized result = voxelize(open.surface(), options);
  EXPECT_TRUE(result.report.winding_number);
  EXPECT_FALSE(result.report.closed);
  EXPECT_NEAR(result.grid.volume / whole.volume(), 1, 2e-4);
  ASSERT_TRUE(result.grid.voxel_coord == exact.voxel_coord);
  for (int64_t v = 0; v < exact.voxel_count(); ++v) {
    Vec3 centre;
    for (int d = 0; d < 3; ++d) centre[d] = exact.rest(exact.corners(v, 0), d) + exact.h / 2;
    if (norm(minus(centre, hole)) < 2 * exact.h) continue;
    ASSERT_NEAR(result.grid.fill(v), exact.fill(v), 4e-3);
    for (int c = 0; c < 8 && exact.fill(v) > 0.2; ++c)
      ASSERT_NEAR(result.grid.shape_mean(v, c), exact.shape_mean(v, c), 5e-3);
  }
}

TEST(Voxelize, AnOpenBoxIsFilledExactlyAtItsFaces) {
  // without half of its lid; the walls stand inside voxels at any offset
  Soup soup = box({0, 0, 0}, {1, 1, 1});
  soup.triangles.erase(soup.triangles.begin() + 3);
  VoxelizeOptions options = {.h = 0.1};
  options.align[0] = 0.0371;
  const Voxelized result = voxelize(soup.surface(), options);
  int64_t walls = 0;
  for (int64_t v = 0; v < result.grid.voxel_count(); ++v) {
    const auto [a, b] =
        overlap(0, 1, result.grid.origin[0], result.grid.h, result.grid.voxel_coord(v, 0));
    const int32_t z = result.grid.voxel_coord(v, 2);
    if (b - a == 1 || z > 7) continue;
    ++walls;
    ASSERT_NEAR(result.grid.fill(v), b - a, 1e-3);
  }
  EXPECT_GE(walls, 160);
}

TEST(Voxelize, OverlappingShellsAreTheirUnion) {
  // two unit spheres one apart: lens of height 1/2 caps, volume pi h^2 (3 - h) / 3 each
  Soup soup = sphere(1, {}, 5);
  soup.add(sphere(1, {1, 0, 0}, 5));
  // half a sphere's area bounds the lens, so triangles take half a sphere's error from its volume
  const double volume = sphere(1, {}, 5).volume();
  const double lens = 2 * M_PI * 0.25 * 2.5 / 3 - (4 * M_PI / 3 - volume) / 2;
  const Voxelized result = voxelize(soup.surface(), {.voxels = 45});
  EXPECT_TRUE(result.report.winding_number);
  EXPECT_NEAR(result.grid.volume, 2 * volume - lens, 5e-4);
  expect_means(result.grid);
}

TEST(Voxelize, ACavityStaysEmpty) {
  Soup soup = sphere(1, {}, 5), inner = sphere(0.5, {}, 4);
  for (size_t t = 0; t < inner.triangles.size(); ++t) inner.turn(t);
  soup.add(inner);
  const Voxelized result = voxelize(soup.surface(), {.voxels = 40});
  EXPECT_FALSE(result.report.winding_number);
  EXPECT_NEAR(result.grid.volume, soup.volume(), 1e-12);
  for (int64_t v = 0; v < result.grid.voxel_count(); ++v) {
    Vec3 centre;
    for (int d = 0; d < 3; ++d)
      centre[d] = result.grid.rest(result.grid.corners(v, 0), d) + result.grid.h / 2;
    ASSERT_GT(norm(centre), 0.5 - 2 * result.grid.h);
  }
}

TEST(Voxelize, PlaceAndSizeDoNotMatter) {
  const Soup plain = sphere(1, {}, 4);
  const VoxelGrid expected = voxelize(plain.surface(), {.voxels = 24}).grid;
  const auto compare = [&](double scale, const Vec3& shift, double tolerance) {
    Soup moved = plain;
    moved.map([&](const Vec3& p) { return plus(scaled(p, scale), shift); });
    const VoxelGrid grid = voxelize(moved.surface(), {.voxels = 24}).grid;
    ASSERT_TRUE(grid.voxel_coord == expected.voxel_coord) << scale;
    for (int64_t v = 0; v < grid.voxel_count(); ++v)
      ASSERT_NEAR(grid.fill(v), expected.fill(v), tolerance) << scale;
    EXPECT_NEAR(grid.volume / (expected.volume * scale * scale * scale), 1, tolerance);
  };
  compare(1e-6, {}, 1e-12);
  compare(5e16, {}, 1e-12);
  compare(1, {1e7, -2e7, 5e6}, 1e-6);
}

TEST(Voxelize, AlignedPlanesAreLayersOfNodes) {
  const Soup soup = sphere(1, {0.1, 0.2, 0.3}, 3);
  VoxelizeOptions options = {.voxels = 20};
  options.align[1] = -0.4321;
  options.align[2] = 0.777;
  const VoxelGrid grid = voxelize(soup.surface(), options).grid;
  for (int d = 1; d < 3; ++d) {
    double nearest = 1;
    for (int64_t n = 0; n < grid.node_count(); ++n)
      nearest = std::min(nearest, std::abs(grid.rest(n, d) - *options.align[d]));
    EXPECT_LT(nearest, 1e-14);
  }
}

TEST(Voxelize, ThreadsDoNotChangeABit) {
  Soup open = sphere(1, {}, 4);
  open.triangles.resize(open.triangles.size() - 9);
  for (const Soup& soup : {sphere(1, {}, 4), open}) {
    VoxelGrid grid[2];
    for (const int threads : {1, 2}) {
      const ThreadLimit control(threads);
      grid[threads - 1] = voxelize(soup.surface(), {.voxels = 30}).grid;
    }
    expect_same(grid[0], grid[1]);
  }
}

TEST(Voxelize, RefusesWhatIsNoSurface) {
  Soup soup = sphere(1, {}, 2);
  EXPECT_THROW(voxelize(soup.surface(), {.voxels = 0}), Error);
  EXPECT_THROW(voxelize(soup.surface(), {.h = -1}), Error);
  EXPECT_THROW(voxelize(soup.surface(), {.h = 2.01}), Error);  // beyond the sphere of radius 1
  EXPECT_NO_THROW(voxelize(soup.surface(), {.h = 2}));
  EXPECT_THROW(voxelize(soup.surface(), {.max_voxels = 0}), Error);
  Surface bad = soup.surface();
  bad.triangles(3, 1) = 1000;
  EXPECT_THROW(voxelize(bad), Error);
  soup.vertices[5][1] = std::nan("");
  EXPECT_THROW(voxelize(soup.surface()), Error);
  Soup line;
  line.vertices = {{0, 0, 0}, {1, 1, 1}};
  line.triangles = {{0, 1, 0}, {1, 0, 1}};
  EXPECT_THROW(voxelize(line.surface()), Error);
  EXPECT_THROW(voxelize(Soup().surface()), Error);
}

}  // namespace
}  // namespace elastogen
