// SPDX-License-Identifier: Apache-2.0
// A level of network/multigrid.hpp as 27-point stencils on bricks of 8x8x8 nodes, as the device
// runs it: every brick has 512 slots, x fastest, whether a node stands there or not, so that places
// of neighbours follow from those of bricks. Nodes that see the same voxels, masses and stiffness
// share one row of weights, so a uniform block needs 27 rows.
//
// Memory: 4 bytes a slot and 84 numbers a row.

#pragma once

#include "network/multigrid.hpp"

#include <array>
#include <vector>

namespace elastogen {

namespace stencil {

inline constexpr int kSlots = 512;     ///< of a brick
inline constexpr int kComponent = 28;  ///< 27 weights, dx + 3 (dy + 3 dz), and 1 / diagonal
inline constexpr int kRow = 3 * kComponent;
inline constexpr int kPartial = 125;  ///< coarse nodes that the nodes of a brick give residual to

}  // namespace stencil

/// Where the bricks around a brick are; the number of bricks of that level where there is none.
struct BrickLinks {
  int32_t neighbour[27];  ///< offsets -1, 0, 1 per axis, x fastest
  int32_t coarse[8];      ///< of the next coarser level: offsets 0, 1 from (coordinate - 1) / 2,
                          ///< rounded down: all that the nodes around the brick have parents in
  int32_t fine[27];       ///< of the next finer level: offsets -1, 0, 1 from twice the coordinate
  int32_t odd;            ///< axes of odd brick coordinate as bits
};

template <class T>
struct StencilBricks {
  std::vector<std::array<int32_t, 3>> coord;  ///< of each brick, in bricks
  std::vector<BrickLinks> links;              ///< (bricks); coarse and fine by link_levels
  std::vector<int32_t> begin;                 ///< first node of each brick, (bricks + 1)
  Zeroed<int32_t> slot;                       ///< of each node: kSlots brick + place
  Zeroed<int32_t> row;  ///< of each slot; 0 where there is no node or a pinned one
  Zeroed<T> rows;       ///< (rows, 3, kComponent); row 0 is 0

  int64_t brick_count() const { return int64_t(coord.size()); }
};

/// The level's operator, (A p)_n = sum over the 27 nodes around n of weight times p, each component
/// for itself, in units of the level; weights of pinned nodes are 0, whatever p says there. Repeats
/// to the bit on any number of threads.
template <class T>
StencilBricks<T> make_stencil_bricks(const MultigridLevel<T>& level);

/// Fills `coarse` of the finer level and `fine` of the coarser one.
template <class T>
void link_levels(StencilBricks<T>& finer, StencilBricks<T>& coarser);

}  // namespace elastogen
