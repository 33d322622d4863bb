// SPDX-License-Identifier: Apache-2.0
#include "voxelize/budget.hpp"

#include "core/error.hpp"
#include "tests/voxelize/shapes.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using namespace test;

TEST(Budget, TheEstimateIsNotBelowTheCount) {
  Soup plate = box({0, 0, 0}, {1, 1, 0.003});
  plate.map([](const Vec3& p) { return turned(p, 0.6); });
  for (const Soup& soup : {sphere(1, {}, 2), sphere(1, {}, 5), plate, sheet(1, 7)})
    for (const double h : {0.3, 0.1, 0.02}) {
      const Surface surface = soup.surface();
      const auto count = voxelize(surface, {.h = h}).grid.voxel_count();
      EXPECT_GE(estimate_voxels(weld(surface), h), static_cast<double>(count)) << h;
    }
}

TEST(Budget, ThinDiagonalsNeedNoBox) {
  // a needle whose box has 1e15 cells
  Soup needle = box({0, -1e-6, -1e-6}, {1, 1e-6, 1e-6});
  needle.map([](const Vec3& p) { return turned(p, 0.7); });
  const Voxelized result = voxelize(needle.surface(), {.h = 1e-5});
  EXPECT_GT(result.grid.voxel_count(), 100'000);
  EXPECT_LT(result.grid.voxel_count(), 400'000);
  EXPECT_EQ(result.grid.pieces, 1);
}

TEST(Budget, RefusesTooMuchAndSuggestsAnEdgeThatFits) {
  const Surface surface = sphere(1, {}, 4).surface();
  for (const VoxelizeOptions& options :
       {VoxelizeOptions{.voxels = 100, .max_voxels = 10'000}, VoxelizeOptions{.h = 1e-5},
        VoxelizeOptions{.voxels = 64, .max_memory = 8 << 20}}) {
    try {
      voxelize(surface, options);
      FAIL() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kResources);
      const std::string text = error.what();
      const size_t place = text.rfind("h = ");
      ASSERT_NE(place, std::string::npos) << text;
      VoxelizeOptions fitting = options;
      fitting.h = std::stod(text.substr(place + 4));
      if (fitting.h > 0.01) {
        EXPECT_GT(voxelize(surface, fitting).grid.voxel_count(), 100) << text;
      }
    }
  }
  EXPECT_THROW(voxelize(surface, {.h = 1e-7}), Error);
}

}  // namespace
}  // namespace elastogen
