// SPDX-License-Identifier: Apache-2.0
// The voxel nearest to a point, by a tree of boxes over the bricks.

#pragma once

#include "core/base.hpp"
#include "core/bricks/index.hpp"

namespace elastogen {

class NearestVoxel {
 public:
  /// @param coords  voxels in the order of a VoxelGrid, (voxels, 3); must outlive this.
  /// @param part    part of each voxel; all voxels of a brick have one part.
  /// @param wanted  only voxels of this part are found.
  explicit NearestVoxel(In<int32_t> coords, In<int32_t> part = {}, int32_t wanted = 0);

  /// Voxel whose closed cube is nearest to a point in lattice coordinates, the first of several.
  int64_t find(const Vec3& point) const;

 private:
  struct Best {
    double distance2;
    int64_t voxel;
  };
  void search(int64_t node, int64_t first, int64_t last, const Vec3& point, Best& best) const;
  Box build(int64_t node, int64_t first, int64_t last);

  Span<const int32_t> coords_;
  std::vector<std::pair<int64_t, int64_t>> bricks_;  ///< first voxel of each, and the end
  std::vector<Box> boxes_;                           ///< children of node n are 2 n + 1 and 2 n + 2
};

}  // namespace elastogen
