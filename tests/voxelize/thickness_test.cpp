// SPDX-License-Identifier: Apache-2.0
// Sheets with a thickness of their own: their volume follows it at any voxel size.

#include "tests/voxelize/shapes.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {
namespace {

using test::Soup;

TEST(Thickness, TheVolumeOfSheetsIsAreaTimesThickness) {
  Soup flat = test::sheet(1, 12), tilted = flat, curved = flat, folded = flat;
  tilted.map([](const Vec3& p) { return test::turned(p, 0.7); });
  curved.map([](const Vec3& p) { return Vec3{p[0], p[1], 0.2 * std::sin(3 * p[0]) * p[1]}; });
  folded.map([](const Vec3& p) { return Vec3{std::abs(p[0] - 0.5), p[1], p[0]}; });
  const Soup shapes[] = {flat, tilted, curved, folded};
  for (const Soup& soup : shapes)
    for (const int voxels : {16, 32, 64})
      for (const double thickness : {0.002, 0.01, 0.03, 0.1}) {
        // where it is folded a thick slab covers a part of itself
        if (thickness > 0.01 && &soup == &shapes[3]) continue;
        const Voxelized v = voxelize(soup.surface(), {.voxels = voxels, .thickness = thickness});
        const double volume = soup.area() * thickness;
        // prisms of a bent sheet cover a part of each other
        const double most = thickness > 0.01 ? 0.025 : 0.005;
        // of the mass, which finish_scene scales to grid.volume
        EXPECT_NEAR(v.grid.volume, volume, most * volume) << voxels << ' ' << thickness;
        EXPECT_NEAR(v.report.sheet_volume, volume, 1e-9 * volume);
        // of the stiffness: floors add a little where the sheet grazes a voxel
        EXPECT_NEAR(v.report.volume, volume, std::max(0.02, most) * volume)
            << voxels << ' ' << thickness;
        EXPECT_EQ(v.grid.pieces, 1);
      }
}

TEST(Thickness, ASheetBesideASolidKeepsBothVolumes) {
  Soup soup = test::box({0, 0, 0}, {0.5, 1, 1});
  const double solid = soup.volume();
  Soup flap = test::sheet(0.5, 5);
  flap.map([](const Vec3& p) { return Vec3{p[0] + 0.5, p[1] + 0.2, 0.43}; });
  soup.add(flap);
  for (const double thickness : {0.004, 0.08}) {
    const Voxelized v = voxelize(soup.surface(), {.voxels = 20, .thickness = thickness});
    EXPECT_NEAR(v.grid.volume, solid + 0.25 * thickness, 0.002 * solid);
    EXPECT_NEAR(v.report.sheet_volume, 0.25 * thickness, 1e-9);
    double beyond = 0;  // the flap alone
    for (int64_t k = 0; k < v.grid.voxel_count(); ++k)
      if (v.grid.rest(v.grid.corners(k, 0), 0) > 0.5 - 1e-9)
        beyond += v.grid.fill(k) * std::pow(v.grid.h, 3);
    EXPECT_NEAR(beyond, 0.25 * thickness, 0.02 * 0.25 * thickness);
  }
}

TEST(Thickness, WithoutItLayersAreFullVoxels) {
  const Voxelized v = voxelize(test::sheet(1, 4).surface(), {.voxels = 10});
  for (int64_t k = 0; k < v.grid.voxel_count(); ++k) EXPECT_EQ(v.grid.fill(k), 1);
  EXPECT_NEAR(v.report.sheet_volume, 0.1, 1e-12);
  EXPECT_EQ(v.grid.volume, 0);
  EXPECT_TRUE(v.grid.sheet.empty());
}

TEST(Thickness, OfSolidsNothingChanges) {
  const Surface surface = test::sphere(0.5, {0, 0, 0}, 3).surface();
  const Voxelized thick = voxelize(surface, {.voxels = 12, .thickness = 0.3});
  const Voxelized plain = voxelize(surface, {.voxels = 12});
  ASSERT_EQ(thick.grid.voxel_count(), plain.grid.voxel_count());
  for (int64_t k = 0; k < plain.grid.voxel_count(); ++k)
    EXPECT_EQ(thick.grid.fill(k), plain.grid.fill(k));
  EXPECT_EQ(thick.grid.volume, plain.grid.volume);
  EXPECT_EQ(thick.report.sheet_volume, 0);
}

}  // namespace
}  // namespace elastogen
