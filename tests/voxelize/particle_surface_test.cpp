// SPDX-License-Identifier: Apache-2.0
#include "voxelize/particle_surface.hpp"

#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "tests/io/test_files.hpp"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetMeasure.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace elastogen {
namespace {

using test::error_of, test::expect_says, test::TempFolder;

constexpr double kSpacing = 0.01;

/// Points of a jittered lattice that lie in a solid, each of a cell's volume.
struct Cloud {
  Array<double> x, volume;

  template <class Inside>
  Cloud(const Vec3& lower, const Vec3& upper, double jitter, const Inside& inside) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> off(-jitter / 2, jitter / 2);
    std::vector<Vec3> points;
    for (double i = lower[0] + kSpacing / 2; i < upper[0]; i += kSpacing)
      for (double j = lower[1] + kSpacing / 2; j < upper[1]; j += kSpacing)
        for (double k = lower[2] + kSpacing / 2; k < upper[2]; k += kSpacing)
          if (inside(Vec3{i, j, k}))
            points.push_back({i + off(random) * kSpacing, j + off(random) * kSpacing,
                              k + off(random) * kSpacing});
    x = Array<double>(int64_t(points.size()), 3);
    volume = Array<double>(x.rows());
    volume.fill(std::pow(kSpacing, 3));
    for (size_t p = 0; p < points.size(); ++p)
      std::copy(points[p].begin(), points[p].end(), x.row(int64_t(p)));
  }

  ParticleCloud view() const { return {x, volume, kSpacing}; }
  double whole() const { return double(x.rows()) * std::pow(kSpacing, 3); }
};

Cloud ball(double radius, double jitter) {
  return {{-radius, -radius, -radius}, {radius, radius, radius}, jitter, [&](const Vec3& p) {
            return norm(p) < radius;
          }};
}

double volume_of(const ParticleSurface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangle)
    sum += dot(surface.position[size_t(t[0])],
               cross(surface.position[size_t(t[1])], surface.position[size_t(t[2])])) /
           6;
  return sum;
}

/// Every directed edge has its reverse.
bool is_closed(const ParticleSurface& surface) {
  std::map<std::pair<int32_t, int32_t>, int> edges;
  for (const auto& t : surface.triangle)
    for (size_t k = 0; k < 3; ++k) {
      const int32_t a = t[k], b = t[(k + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  return std::ranges::all_of(edges, [](const auto& edge) { return edge.second == 0; });
}

TEST(ParticleSurface, OfABallHasItsVolumeAndShape) {
  constexpr double kRadius = 0.1;
  for (const double jitter : {0.0, 1.0}) {
    const Cloud cloud = ball(kRadius, jitter);
    const ParticleSurface surface = particle_surface(cloud.view());
    EXPECT_TRUE(is_closed(surface));
    EXPECT_NEAR(volume_of(surface) / cloud.whole(), 1, 0.01);
    for (const Vec3& p : surface.position) EXPECT_NEAR(norm(p), kRadius, kSpacing);
  }
}

TEST(ParticleSurface, OfABoxHasItsVolume) {
  const Cloud cloud({0, 0, 0}, {0.2, 0.1, 0.05}, 1, [](const Vec3&) { return true; });
  const ParticleSurface surface = particle_surface(cloud.view());
  EXPECT_TRUE(is_closed(surface));
  EXPECT_NEAR(volume_of(surface) / cloud.whole(), 1, 0.01);
}

TEST(ParticleSurface, AParticleByItselfIsABallOfItsVolume) {
  const double radius = std::cbrt(3 * std::pow(kSpacing, 3) / (4 * std::numbers::pi));
  const Cloud one({0, 0, 0}, {kSpacing, kSpacing, kSpacing}, 0, [](const Vec3&) { return true; });
  ASSERT_EQ(one.x.rows(), 1);
  const ParticleSurface surface = particle_surface(one.view());
  EXPECT_TRUE(is_closed(surface));
  EXPECT_NEAR(volume_of(surface) / one.whole(), 1, 0.15);  // of two cells across
  const Vec3 middle = {kSpacing / 2, kSpacing / 2, kSpacing / 2};
  for (const Vec3& p : surface.position)
    EXPECT_NEAR(norm(minus(p, middle)), radius, 0.25 * kSpacing);
}

TEST(ParticleSurface, IsTheSameOnAnyNumberOfThreads) {
  const Cloud cloud = ball(0.08, 1);
  const ParticleSurface all = particle_surface(cloud.view());
  const ThreadLimit one(1);
  const ParticleSurface alone = particle_surface(cloud.view());
  EXPECT_EQ(all.position, alone.position);
  EXPECT_EQ(all.triangle, alone.triangle);
}

TEST(ParticleSurface, OfNothingIsEmptyAndBadInputIsRefused) {
  EXPECT_TRUE(particle_surface({{nullptr, 0, 3}, {nullptr, 0, 1}, 1}).triangle.empty());
  const Array<double> x(2, 3), volume(1);
  expect_says(error_of(
                  [&] {
                    particle_surface({x, volume, 1});
                  },
                  ErrorKind::kUsage),
              "x and volume must be");
  expect_says(error_of(
                  [&] {
                    particle_surface({x, Array<double>(2), 0});
                  },
                  ErrorKind::kUsage),
              "the spacing of particles must be positive");
}

TEST(NearestParticle, IsTheOneThatAllDistancesSay) {
  const Cloud cloud = ball(0.05, 1);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-0.2, 0.2);
  std::vector<Vec3> points;
  for (int k = 0; k < 200; ++k) points.push_back({place(random), place(random), place(random)});
  const std::vector<int32_t> nearest = nearest_particles(cloud.x, kSpacing, points);
  for (size_t k = 0; k < points.size(); ++k) {
    double best = 1e300;
    int32_t wanted = -1;
    for (int64_t p = 0; p < cloud.x.rows(); ++p) {
      const double d = norm(minus({cloud.x(p, 0), cloud.x(p, 1), cloud.x(p, 2)}, points[k]));
      if (d < best) best = d, wanted = int32_t(p);
    }
    EXPECT_EQ(nearest[k], wanted);
  }
  EXPECT_TRUE(nearest_particles(Array<double>(0, 3), 1, {}).empty());
  expect_says(
      error_of([&] { nearest_particles(Array<double>(0, 3), 1, points); }, ErrorKind::kUsage),
      "one particle at least");
}

TEST(ParticleVdb, HasDensitySurfaceAndVelocityAtTheirPlace) {
  const TempFolder folder;
  const Cloud cloud = ball(0.1, 1);
  Array<double> v(cloud.x.rows(), 3);
  for (int64_t k = 0; k < v.rows(); ++k) v(k, 0) = 2, v(k, 1) = -cloud.x(k, 2);
  write_particle_vdb(folder.path("a.vdb"), cloud.view(), v, {5, 0, 0});
  openvdb::io::File file(folder.path("a.vdb"));
  file.open(false);
  const auto surface = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("surface"));
  const auto density = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
  const auto velocity = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("velocity"));
  EXPECT_EQ(surface->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_EQ(density->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_NEAR(openvdb::tools::levelSetVolume(*surface) / cloud.whole(), 1, 0.02);
  const auto at = [](const auto& grid, const openvdb::Vec3d& x) {
    return grid->tree().getValue(grid->transform().worldToIndexCellCentered(x));
  };
  EXPECT_EQ(at(density, {5, 0, 0}), 1);
  EXPECT_EQ(at(density, {5, 0, 0.12}), 0);
  EXPECT_LT(at(surface, {5.05, 0, 0}), 0);
  EXPECT_GT(at(surface, {5.12, 0, 0}), 0);
  // means over cells of two spacings, in floats of 16 bits
  const openvdb::Vec3f above = at(velocity, {5, 0, 0.06});
  EXPECT_NEAR(above[0], 2, 2e-3);
  EXPECT_NEAR(above[1], -0.06, kSpacing);
  EXPECT_NEAR(above[2], 0, 1e-6);
}

TEST(ParticleVdb, SaysWhatItCannotWrite) {
  const TempFolder folder;
  const Cloud cloud = ball(0.03, 0);
  const Array<double> v(cloud.x.rows(), 3);
  expect_says(error_of([&] { write_particle_vdb("/none/a.vdb", cloud.view(), v, {}); },
                       ErrorKind::kResources),
              "/none/a.vdb");
  expect_says(
      error_of(
          [&] { write_particle_vdb(folder.path("a.vdb"), cloud.view(), Array<double>(1, 3), {}); },
          ErrorKind::kUsage),
      "v must be");
  Array<double> tiny = cloud.x;
  for (int64_t k = 0; k < tiny.size(); ++k) tiny.data()[k] *= 1e-9;
  const ParticleCloud small = {tiny, cloud.volume, 1e-9 * kSpacing};
  expect_says(
      error_of([&] { write_particle_vdb(folder.path("a.vdb"), small, v, {}); }, ErrorKind::kUsage),
      "OpenVDB holds no cells as small");
  EXPECT_FALSE(std::filesystem::exists(folder.path("a.vdb")));
}

}  // namespace
}  // namespace elastogen
