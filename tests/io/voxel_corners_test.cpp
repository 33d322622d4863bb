// SPDX-License-Identifier: Apache-2.0
#include "io/voxel_corners.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

/// A full voxel and, beside it along x, one that is filled next to their common face alone: its
/// mean shape functions are those of the plane x = 1 + 0.05.
VoxelGrid two_voxels() {
  VoxelGrid grid;
  grid.h = 1;
  grid.rest = Array<double>(12, 3);
  for (int n = 0; n < 12; ++n) {
    const int at[3] = {n % 3, n / 3 % 2, n / 6};
    for (int d = 0; d < 3; ++d) grid.rest(n, d) = at[d];
  }
  grid.corners = Array<int32_t>(2, 8);
  grid.fill = Array<double>(2, 1);
  grid.shape_mean = Array<double>(2, 8);
  grid.fill(0, 0) = 1;
  grid.fill(1, 0) = 0.1;
  for (int v = 0; v < 2; ++v)
    for (int c = 0; c < 8; ++c) {
      grid.corners(v, c) = v + c % 2 + 3 * (c / 2 % 2) + 6 * (c / 4);
      grid.shape_mean(v, c) = v == 0 ? 0.125 : (c % 2 ? 0.05 : 0.95) / 4;
    }
  return grid;
}

/// u = A X + b.
Array<double> linear(const VoxelGrid& grid) {
  const double A[9] = {0.1, 0.2, -0.3, 0.4, -0.5, 0.6, 0.7, 0.8, -0.9};
  Array<double> u(grid.rest.rows(), 3);
  for (int64_t n = 0; n < u.rows(); ++n)
    for (int i = 0; i < 3; ++i) {
      u(n, i) = 0.5 * i - 1;
      for (int d = 0; d < 3; ++d) u(n, i) += A[3 * i + d] * grid.rest(n, d);
    }
  return u;
}

TEST(VoxelCorners, LinearFieldsStayAsTheyAre) {
  const VoxelGrid grid = two_voxels();
  const VoxelCorners corners(grid);
  EXPECT_EQ(corners.carried(), 4);
  const Array<double> u = linear(grid), drawn = corners.drawn(u);
  for (int64_t k = 0; k < u.size(); ++k) EXPECT_NEAR(drawn.data()[k], u.data()[k], 1e-14);
}

TEST(VoxelCorners, ASpikeOfACornerThatTheBodyHardlyHasIsTakenAway) {
  const VoxelGrid grid = two_voxels();
  const Array<double> u = linear(grid);
  Array<double> spike = u;
  spike(2, 1) += 30;   // of the far face
  spike(0, 0) += 0.3;  // of the full voxel, which stays
  const Array<double> drawn = VoxelCorners(grid).drawn(spike);
  EXPECT_EQ(drawn(0, 0), spike(0, 0));
  // the rest is the share of its support, and its effect on the mean and slope of its voxel
  const double support = 0.1 * 0.05 / 4 / VoxelCorners::kSupport;
  EXPECT_LT(std::abs(drawn(2, 1) - u(2, 1)), 30 * (support + 0.4));
  EXPECT_LT(std::abs(drawn(2, 1) - u(2, 1)), 0.5 * 30);
}

TEST(VoxelCorners, RefusesAFieldOfAnotherLength) {
  const VoxelGrid grid = two_voxels();
  EXPECT_ANY_THROW(VoxelCorners(grid).drawn(Array<double>(5, 3)));
}

}  // namespace
}  // namespace elastogen
