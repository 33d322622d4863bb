// SPDX-License-Identifier: Apache-2.0
// The levels of multigrid.hpp as stencils (stencil_bricks.hpp), made on the device
// from the tables of a potential. Moduli, masses and pins are stored by slot and averaged from
// level to level; nodes with equal rows share one row. The bricks of each level come from the host.

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
  DeviceArray<int32_t> row;    ///< row of each slot; 0 where there is no node or a pinned one
  DeviceArray<T> rows;         ///< (rows, 3, kComponent); row 0 is 0
  double lambda_max = 0;       ///< bound of the smoother
};

template <class T>
struct Hierarchy {
  std::vector<HierarchyLevel<T>> levels;  ///< 0 the finest
  double unit = 1;                        ///< [N/m]; the operators are divided by it
  DeviceArray<double> operators;  ///< of the coarsest level, (3, pitch, pitch) of dense.cuh,
                                  ///< 1 on the diagonal of pinned nodes; empty if it is not solved
};

/// Levels for the scene and the scheme of a potential. They equal those of Multigrid to rounding,
/// and every run gives the same bits. While memory is only counted (MemoryCount) the count of rows
/// is estimated and nothing is launched.
/// @param hash_bits  bits of the hash by which rows are told apart first; with few bits, as in
///                   tests, number_rows needs more rounds.
/// @throws Error (resources) if the device has too little memory.
template <class T>
Hierarchy<T> make_hierarchy(DevicePotential& potential, int hash_bits = 64);

}  // namespace elastogen::cuda
