// SPDX-License-Identifier: Apache-2.0
// The levels of network/precondition/multigrid.hpp as stencils (network/precondition/stencil_bricks.hpp), made on the device
// from the tables of a potential: moduli, masses and pins by slot, averaged from level to level,
// and of the rows of all nodes one of each kind. The host knows where bricks lie.

#pragma once

#include "core/cuda/array.cuh"
#include "network/potential/incremental_potential_device.hpp"
#include "network/precondition/stencil_bricks.hpp"

namespace elastogen::cuda {

/// A level for the kernels of the cycle.
template <class T>
struct HierarchyLevel {
  DeviceArray<BrickLinks> links;
  DeviceArray<int32_t> begin;  ///< first node of each brick, (bricks + 1)
  DeviceArray<int32_t> slot;   ///< of each node: kSlots brick + place
  DeviceArray<int32_t> row;    ///< of each slot; 0 where there is no node or a pinned one
  DeviceArray<T> rows;         ///< (rows, 3, kComponent); row 0 is 0
  double lambda_max = 0;       ///< bound of the smoother
};

template <class T>
struct Hierarchy {
  std::vector<HierarchyLevel<T>> levels;  ///< 0 the finest
  double unit = 1;                        ///< [N/m], what the operators are divided by
  DeviceArray<double> operators;  ///< of the coarsest level, (3, pitch, pitch) of dense.cuh,
                                  ///< 1 on the diagonal of pinned nodes; empty where that smooths
};

/// Levels of the scene and scheme of a potential, equal to those of Multigrid to rounding; the same
/// bits on every run. While room is counted (RoomCount) rows are estimated, and nothing is
/// launched.
/// @param hash_bits  by which rows are told apart before their numbers are; few of them, for tests,
///                   take more rounds.
/// @throws Error (resources) where the device has no room.
template <class T>
Hierarchy<T> make_hierarchy(DevicePotential& potential, int hash_bits = 64);

}  // namespace elastogen::cuda
