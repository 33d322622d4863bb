// SPDX-License-Identifier: Apache-2.0
// The low-frequency modes of the encoders: cosines over the box of a body, which vanish smoothly at
// its pins.

#pragma once

#include "core/scene.hpp"

#include <array>
#include <vector>

namespace elastogen {

/// Wave numbers k_x, k_y, k_z of a cosine mode.
using Wave = std::array<int, 3>;

/// The `count` waves of smallest sum (k_d/L_d)^2 in a box of extents L; ties by wave number.
std::vector<Wave> lowest_waves(const Box& box, int count);

/// prod_d cos(pi k_d (X_d - lower_d)/L_d) of some waves at the nodes of a grid, from tables over
/// the planes of its lattice.
class PlaneCosines {
 public:
  /// @param nodes  their lattice coordinates bound the tables; box holds their rest positions.
  PlaneCosines(const VoxelGrid& grid, const std::vector<int32_t>& nodes, std::vector<Wave> waves,
               const Box& box);
  /// Of wave w at a node of the lattice coordinates `at`.
  double operator()(int w, const int32_t at[3]) const {
    double value = 1;
    for (size_t d = 0; d < 3; ++d)
      value *= table_[d][size_t(at[d] - first_[d]) * waves_.size() + size_t(w)];
    return value;
  }

 private:
  std::vector<Wave> waves_;
  int32_t first_[3];              // plane of each axis
  std::vector<double> table_[3];  // (planes, waves)
};

/// Distance of each listed node to the nearest pinned one of its piece [m]; 1e300 where there is
/// none.
/// @param nodes  all those of some pieces.
Zeroed<double> pin_distance(const Scene& scene, const std::vector<int32_t>& nodes);

}  // namespace elastogen
