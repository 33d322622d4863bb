// SPDX-License-Identifier: Apache-2.0
// Levels of lattice points in bricks of 8x8x8, each with twice the edge of the finer one, and the
// bricks around each brick. A brick has 512 slots, x fastest, whether or not they hold a point, so
// that neighbouring slots follow from neighbouring bricks.

#pragma once

#include "core/bricks/index.hpp"

namespace elastogen {

namespace bricks {

inline constexpr int kSlots = 512;  ///< of a brick

}  // namespace bricks

/// Numbers of the bricks around a brick; where there is none, the count of bricks of that level.
struct BrickLinks {
  int32_t neighbour[27];  ///< offsets -1, 0, 1 per axis, x fastest
  int32_t coarse[8];      ///< of the next coarser level: offsets 0, 1 from (coordinate - 1) / 2,
                          ///< rounded down: all bricks with parents of the nodes around this brick
  int32_t fine[27];       ///< of the next finer level: offsets -1, 0, 1 from twice the coordinate
  int32_t odd;            ///< axes of odd brick coordinate as bits
};

/// Voxels and nodes of a level, and links between the bricks of its nodes.
struct BrickLevel {
  BrickIndex voxels, nodes;

  // filled by link_bricks
  std::vector<int32_t> node_brick;  ///< brick of nodes at the place of each brick of voxels
  std::vector<BrickLinks> links;  ///< (bricks of nodes); `coarse` and `fine` if such a level exists

  int64_t brick_count() const { return nodes.brick_count(); }
};

/// Fills home and links of each level, the finest first.
void link_bricks(std::vector<BrickLevel>& levels);

}  // namespace elastogen
