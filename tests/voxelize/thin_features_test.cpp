// SPDX-License-Identifier: Apache-2.0
#include "voxelize/thin_features.hpp"

#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

VoxelGrid grid_of(const std::vector<std::array<int, 3>>& voxels) {
  Array<int32_t> coords(static_cast<int64_t>(voxels.size()), 3);
  for (int64_t v = 0; v < coords.rows(); ++v)
    for (int d = 0; d < 3; ++d) coords(v, d) = voxels[v][d];
  return make_grid(coords, 1, {});
}

TEST(ThinFeatures, VoxelsThatShareAnEdgeOrACornerAreHinges) {
  EXPECT_EQ(hinge_count(grid_of({{0, 0, 0}, {1, 0, 0}})), 0);
  EXPECT_EQ(hinge_count(grid_of({{0, 0, 0}, {1, 1, 0}})), 1);
  EXPECT_EQ(hinge_count(grid_of({{0, 0, 0}, {1, 1, 1}})), 1);
  EXPECT_EQ(hinge_count(grid_of({{0, 0, 0}, {2, 0, 0}})), 0);
  EXPECT_EQ(hinge_count(grid_of({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {9, 9, 9}})), 2);
  EXPECT_EQ(hinge_count(grid_of({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}})), 0);
}

TEST(ThinFeatures, FindingsCountPiecesAndHinges) {
  EXPECT_TRUE(check_grid(make_box(2, 3, 4, 1)).empty());
  const auto findings = check_grid(grid_of({{0, 0, 0}, {1, 1, 0}, {5, 5, 5}}));
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].what, "loose-pieces");
  EXPECT_EQ(findings[0].count, 2);
  EXPECT_EQ(findings[1].what, "hinges");
  EXPECT_EQ(findings[1].count, 1);
}

}  // namespace
}  // namespace elastogen
