// SPDX-License-Identifier: Apache-2.0
#include "io/voxel_corners.hpp"

#include "core/error.hpp"
#include "core/hex8.hpp"

#include <algorithm>

namespace elastogen {

Mat3<double> mean_slope(const VoxelGrid& grid, int64_t voxel, const Array<double>& u) {
  double M[7];
  hex8::fill_moments(grid.shape_mean.row(voxel), M);
  Mat3<double> result = {};
  for (int i = 0; i < 3; ++i) {
    double at[8], slope[3];
    for (int c = 0; c < 8; ++c) at[c] = u(grid.corners(voxel, c), i);
    hex8::to_patterns(at);
    hex8::gradient<true>(at, M, slope);
    for (int d = 0; d < 3; ++d) result(i, d) = slope[d] / (4 * grid.h);
  }
  return result;
}

VoxelCorners::VoxelCorners(const VoxelGrid& grid)
    : grid_(grid), support_(size_t(grid.node_count()), 0) {
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    for (int c = 0; c < 8; ++c)
      support_[size_t(grid.corners(v, c))] += grid.fill.data()[v] * grid.shape_mean(v, c);
  const auto is_carried = [&](int32_t node) { return support_[size_t(node)] < kSupport; };
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    if (std::any_of(grid.corners.row(v), grid.corners.row(v) + 8, is_carried)) voxels_.push_back(v);
  carried_ = std::count_if(support_.begin(), support_.end(), [](double s) { return s < kSupport; });
}

Array<double> VoxelCorners::drawn(const Array<double>& u) const {
  ELASTOGEN_CHECK(Span<const double>(u).is(grid_.node_count(), 3), "u must be (",
                  grid_.node_count(), ", 3), got (", u.rows(), ", ", u.cols(), ')');
  // each voxel gives its light corners the linear field of its filled part
  Array<double> sum(grid_.node_count(), 3), weight(grid_.node_count(), 1);
  for (const int64_t v : voxels_) {
    const Mat3<double> slope = mean_slope(grid_, v, u);
    // means of position and field over the filled part
    Vec3 X = {}, mean = {};  // sums over the eight shape functions
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 3; ++d) {
        const int32_t n = grid_.corners(v, c);
        X[size_t(d)] += grid_.shape_mean(v, c) * grid_.rest(n, d);
        mean[size_t(d)] += grid_.shape_mean(v, c) * u(n, d);
      }
    const double fill = grid_.fill.data()[v];
    // that field at its light corners, weighted by the fill
    for (int c = 0; c < 8; ++c) {
      const int32_t n = grid_.corners(v, c);
      if (support_[size_t(n)] >= kSupport) continue;
      weight(n, 0) += fill;
      for (int i = 0; i < 3; ++i) {
        double at = mean[size_t(i)];
        for (int d = 0; d < 3; ++d) at += slope(i, d) * (grid_.rest(n, d) - X[size_t(d)]);
        sum(n, i) += fill * at;
      }
    }
  }
  // a node keeps as much of its own value as its support says
  Array<double> result = u;
  for (int64_t n = 0; n < u.rows(); ++n) {
    const double share = support_[size_t(n)] / kSupport;
    if (share >= 1 || weight(n, 0) == 0) continue;
    for (int i = 0; i < 3; ++i)
      result(n, i) = share * u(n, i) + (1 - share) * sum(n, i) / weight(n, 0);
  }
  return result;
}

}  // namespace elastogen
