// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/stencil_bricks.hpp"

namespace elastogen {

std::vector<BrickLevel> make_stencil_levels(const VoxelGrid& grid, int64_t dense) {
  std::vector<BrickLevel> levels(1);
  levels[0].voxels = BrickIndex(grid.voxel_coord);
  levels[0].nodes = levels[0].voxels.corners();
  while (levels.back().nodes.point_count() > dense && int(levels.size()) < kMostLevels) {
    BrickLevel coarse;
    coarse.voxels = levels.back().voxels.halved();
    coarse.nodes = coarse.voxels.corners();
    if (!is_worthwhile(coarse.nodes.point_count(), levels.back().nodes.point_count())) break;
    levels.push_back(std::move(coarse));
  }
  link_bricks(levels);
  return levels;
}

}  // namespace elastogen
