// SPDX-License-Identifier: Apache-2.0
// An additional stiffness of nodes on the levels of the V-cycle, from that on the finest level: as
// Multigrid::set_nodal_stiffness, on the device.

#pragma once

#include "core/cuda/inverse.cuh"
#include "network/precondition/stencil.cuh"

namespace elastogen::cuda {

/// P^T of the finer level's stiffness at the free slots of a brick; one block for each brick, one
/// thread for each slot. A thread adds the stiffness of the finer nodes around its own, halved for
/// each axis along which they are odd, in the order of the host. The block marks whether its brick
/// has any, so that bricks without it are skipped.
template <class T>
__global__ void __launch_bounds__(stencil::kSlots)
    stiffness_kernel(StencilView<T> fine, StencilView<T> coarse) {
  const int place = int(threadIdx.x);
  const int64_t slot = int64_t(blockIdx.x) * stencil::kSlots + place;
  const BrickLinks& links = coarse.links[blockIdx.x];
  const int at[3] = {place % 8, place / 8 % 8, place / 64};
  const bool is_free = coarse.row[slot] != 0;
  T sum[3] = {};
#pragma unroll
  for (int k = 0; k < 27; ++k) {
    const int x = 2 * at[0] + k % 3 - 1, y = 2 * at[1] + k / 3 % 3 - 1, z = 2 * at[2] + k / 9 - 1;
    const int32_t brick = links.fine[(x >> 3) + 1 + 3 * ((y >> 3) + 1) + 9 * ((z >> 3) + 1)];
    if (!is_free || fine.stiff[brick] == 0) continue;
    const int child = (x & 7) + 8 * ((y & 7) + 8 * (z & 7));
    const int halvings = (k % 3 != 1) + (k / 3 % 3 != 1) + (k / 9 != 1);
    const T* from = fine.added + (int64_t(brick) * stencil::kSlots + child) * 3;
    for (int i = 0; i < 3; ++i) sum[i] += from[i] / T(1 << halvings);
  }
  for (int i = 0; i < 3; ++i) coarse.added[3 * slot + i] = sum[i];
  const int any = __syncthreads_or(sum[0] != 0 || sum[1] != 0 || sum[2] != 0);
  if (place == 0) coarse.stiff[blockIdx.x] = any;
}

/// For a level that is solved, of at most 100 nodes where there is contact, and for a small one.
using StiffTile = InverseTile<7>;
using SmallStiffTile = InverseTile<4>;

/// Inverses of the three dense operators (dense.cuh) with the additional stiffness, by one
/// block for each, which holds the matrix in registers.
template <class T, class Tile>
__global__ void __launch_bounds__(Tile::kThreads)
    inverse_kernel(StencilView<T> v, const double* operators, T* inverses) {
  __shared__ typename Tile::Scratch scratch;
  const int n = v.nodes, component = int(blockIdx.x);
  const int64_t first = int64_t(component) * v.pitch * v.pitch;
  Tile tile(n, [&](int i, int j) {
    const T more = i == j ? v.added[3 * int64_t(v.slot[i]) + component] : T(0);
    return operators[first + i * v.pitch + j] + double(more);
  });
  tile.invert(scratch);
  tile.for_entries([&](int i, int j, double value) {
    if (i < n && j < n) inverses[(int64_t(component) * n + i) * v.pitch + j] = T(value);
  });
}

}  // namespace elastogen::cuda
