// SPDX-License-Identifier: Apache-2.0
// Where corners of voxels are drawn whose voxels the body hardly fills.

#pragma once

#include "core/mat3.hpp"
#include "core/voxel_grid.hpp"

#include <vector>

namespace elastogen {

/// Mean slope du/dX of a nodal field over the filled part of a voxel (docs/formats.md, "Elastic
/// force"). @param u  (nodes, 3).
Mat3<double> mean_slope(const VoxelGrid& grid, int64_t voxel, const Array<double>& u);

/// A node far from the filled part of all its voxels hardly changes the mean gradients that the
/// energy is made of, so that its place is as good as free: drawn, it would be a spike. It is
/// carried by its voxels instead, each with its mean value and slope,
///
///     u'_n = s u_n + (1 - s) sum_v w_v (u_v + du/dX_v (X_n - X_v)) / sum_v w_v,
///
/// w_v the fill, X_v and u_v the means over the filled part, s = min(1, support / kSupport), the
/// support of a node the sum of fill times mean shape function: 1 within the body, 1/2 on a side of
/// full voxels, 1/8 at a corner. Linear fields stay as they are.
class VoxelCorners {
 public:
  static constexpr double kSupport = 0.1;

  /// @param grid  must outlive it.
  explicit VoxelCorners(const VoxelGrid& grid);

  /// The field as it is drawn. @param u  displacement or velocity, (nodes, 3).
  Array<double> drawn(const Array<double>& u) const;

  /// Nodes that are carried.
  int64_t carried() const { return carried_; }

 private:
  const VoxelGrid& grid_;
  std::vector<double> support_;  ///< of each node
  std::vector<int64_t> voxels_;  ///< that have a carried corner
  int64_t carried_ = 0;
};

}  // namespace elastogen
