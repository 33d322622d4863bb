// SPDX-License-Identifier: Apache-2.0
// A level of stencil_bricks.hpp on the device, and the work of single threads on it: the
// residual of a coarser level and, by a warp, the dense solve of the coarsest.
//
// Vectors of a level are (bricks, kSlots, 3). z and other have one brick more, which stands for
// missing neighbours. Slots without a free node always hold 0 in every vector.

#pragma once

#include "network/precondition/stencil_bricks.hpp"

namespace elastogen::cuda {

/// Tables and vectors of a level, as kernels use them.
template <class T>
struct StencilView {
  const BrickLinks* links;
  const int32_t *begin, *slot, *row;
  const T *rows, *inverses;    ///< inverses: (3, nodes, pitch) of a level that a cluster solves
  T *r, *z, *other, *partial;  ///< partial: (bricks + 1, kPartial, 3)
  int32_t bricks, nodes;
  T first, keep, add;           ///< of the Chebyshev polynomial
  const T* coarse_z = nullptr;  ///< z of the next coarser level; nullptr: there is none
  T* added = nullptr;        ///< additional diagonal stiffness, (bricks + 1, kSlots, 3), or nullptr
  int32_t* stiff = nullptr;  ///< bricks in which it is not all 0, (bricks + 1)
  int32_t pitch = 0;         ///< dense_pitch of the nodes, of a level that is solved

  /// The inverse of a diagonal entry after `more` is added to it.
  __device__ static T with_added(T inverse, T more) { return inverse / (1 + inverse * more); }
};

/// Sets r of a slot, and the start of the smoother from it; skips slots without a free node.
template <class T>
__device__ inline void set_residual(const StencilView<T>& v, int slot, const T r[3]) {
  const int64_t row = v.row[slot], k = 3 * int64_t(slot);
  if (row == 0) return;
  const T* inverse = v.rows + row * stencil::kRow + 27;
  const bool stiff = v.added != nullptr && v.stiff[slot / stencil::kSlots] != 0;
  for (int i = 0; i < 3; ++i) {
    T of = inverse[i * stencil::kComponent];
    if (stiff) of = v.with_added(of, v.added[k + i]);
    v.r[k + i] = r[i];
    v.other[k + i] = v.first * of * r[i];
  }
}

/// The place where kernels put the residual of a cycle.
template <class T>
struct ResidualInput {
  StencilView<T> finest;
  T scale;

  /// Sets the residual of a node, free or pinned.
  __device__ void set(int64_t n, const T r[3]) const {
    const T value[3] = {scale * r[0], scale * r[1], scale * r[2]};
    set_residual(finest, finest.slot[n], value);
  }
};

/// The partial sums of the finer level that make r of a coarse slot: those of the brick that begins
/// at its node or holds it, and of the bricks before that end there. The constructor reads only
/// tables that no kernel writes, so it may come before the wait.
struct Restriction {
  int32_t place[8];  ///< of three numbers in `partial`, -1: none

  Restriction() = default;

  /// The places for a slot, none if it has no free node.
  __device__ Restriction(const BrickLinks* links, const int32_t* row, int slot) {
    const int32_t* const fine = links[slot / stencil::kSlots].fine;
    const int at[3] = {slot % 8, slot / 8 % 8, slot / 64 % 8};
    const bool free = read_early(row + slot) != 0;
#pragma unroll
    for (int c = 0; c < 8; ++c) {
      int brick = 0, q = 0, first = 1, width = 1;
      bool reached = free;
#pragma unroll
      for (int d = 0; d < 3; ++d, first *= 3, width *= 5) {
        const int before = c >> d & 1, rest = at[d] & 3;
        reached &= !before || rest == 0;
        brick += first * ((at[d] >> 2) + 1 - before);
        q += width * (before ? 4 : rest);
      }
      place[c] = reached ? read_early(fine + brick) * stencil::kPartial + q : -1;
    }
  }

  template <class T>
  __device__ T sum(const T* partial, int component) const {
    T sum = 0;
#pragma unroll
    for (int c = 0; c < 8; ++c)
      if (place[c] >= 0) sum += partial[3 * int64_t(place[c]) + component];
    return sum;
  }

  /// Sets r of a slot, and the start of the smoother.
  template <class T>
  __device__ void set(const T* partial, const StencilView<T>& coarse, int slot) const {
    const T r[3] = {sum(partial, 0), sum(partial, 1), sum(partial, 2)};
    set_residual(coarse, slot, r);
  }
};

/// The place where kernels put the result of a cycle.
template <class T>
struct ResultOutput {
  T* z = nullptr;           ///< by node, (nodes, 3); nullptr: to z of the level
  const T* plus = nullptr;  ///< what is added to it, or nullptr

  __device__ void set(int64_t k, T value) const {
    z[k] = plus == nullptr ? value : value + plus[k];
  }
};

/// z_i = A_i^-1 r_i at number k = component nodes + node, by a warp: each lane adds every 32nd
/// product of a row, then the lanes are added. The inverses are symmetric.
template <class T>
__device__ inline void solve(const StencilView<T>& v, int k, const ResultOutput<T>& out) {
  const int component = k / v.nodes, node = k % v.nodes, lane = int(threadIdx.x) % 32;
  const T* inverse = v.inverses + int64_t(k) * v.pitch;
  T sum = 0;
  for (int m = lane; m < v.nodes; m += 32)
    sum += inverse[m] * v.r[3 * int64_t(v.slot[m]) + component];
  for (int half = 16; half > 0; half /= 2) sum += __shfl_down_sync(~0u, sum, half);
  if (lane > 0) return;
  if (out.z != nullptr)
    out.set(3 * node + component, sum);
  else
    v.z[3 * int64_t(v.slot[node]) + component] = sum;
}

}  // namespace elastogen::cuda
