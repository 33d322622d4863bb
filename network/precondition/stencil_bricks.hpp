// SPDX-License-Identifier: Apache-2.0
// The levels of network/precondition/multigrid.hpp as 27-point stencils on bricks of 8x8x8 nodes
// (core/bricks/links.hpp), as the device runs them. Nodes that see the same voxels, masses and pins
// share one row of weights, so a uniform block needs 27 rows.
//
// This header has the levels of a grid and the row of a node; multigrid_grid.cu finds the
// distinct rows of a scene.

#pragma once

#include "core/bricks/links.hpp"
#include "network/precondition/multigrid_element.hpp"
#include "network/precondition/multigrid_grid.hpp"

namespace elastogen {

namespace stencil {

using bricks::kSlots;
inline constexpr int kComponent = 28;  ///< 27 weights, dx + 3 (dy + 3 dz), and 1 / diagonal
inline constexpr int kRow = 3 * kComponent;
inline constexpr int kPartial = 125;  ///< coarse nodes that get residual from a brick

}  // namespace stencil

/// The levels of Multigrid, the finest first.
/// @param dense  dense_nodes of the scene.
std::vector<BrickLevel> make_stencil_levels(const VoxelGrid& grid, int64_t dense);

/// One component of a node's row: the weights of the 27 nodes around it in the level's operator,
/// (A p)_n = sum of weight times p, in units of the level, and 1 / its diagonal, 0 if that is not
/// positive. Weights of pinned nodes are 0, so p does not matter there.
/// @param voxel  voxel(c, k, M): whether the node is corner c of a voxel; if so, puts its moduli
///               times h over the level's unit into k[6] and the moments of its fill into M[7].
/// @param pins   which of the 27 are pinned, as bits.
/// @param added  the node's inertia over the unit, plus its additional stiffness.
template <class T, class Voxel>
ELASTOGEN_HD inline void stencil_row(int component, const Voxel& voxel, uint32_t pins, T added,
                                     T row[stencil::kComponent]) {
  double weights[27] = {};
  for (int c = 0; c < 8; ++c) {
    double k[6], M[7], unit[8] = {}, f[8];
    if (!voxel(c, k, M)) continue;
    unit[c] = 1;
    scalar_element<true>(k, M, component, unit, f);  // a column, equal to the row by symmetry
    for (int q = 0; q < 8; ++q) {
      const int dx = (q & 1) - (c & 1), dy = (q >> 1 & 1) - (c >> 1 & 1), dz = (q >> 2) - (c >> 2);
      weights[13 + dx + 3 * dy + 9 * dz] += f[q];
    }
  }
  const T diagonal = T(weights[13]) + added;
  for (int j = 0; j < 27; ++j) row[j] = pins >> j & 1 ? T(0) : T(weights[j]);
  row[13] = T(weights[13] + double(added));
  row[27] = diagonal > 0 ? 1 / diagonal : T(0);
}

}  // namespace elastogen
