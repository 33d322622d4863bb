// SPDX-License-Identifier: Apache-2.0
// The coarsest level of the V-cycle, which is solved: inverses of its dense operators A_d, and
// z_d = A_d^-1 r_d by the whole card.

#pragma once

#include "core/device_array.cuh"
#include "network/device_stencil.cuh"

namespace elastogen::cuda {

inline constexpr int kDenseTile = 64;  ///< rows of the tiles of a matrix

/// Numbers from one row of a matrix of n rows to the next: whole tiles.
inline int64_t dense_pitch(int64_t n) {
  return (n + kDenseTile - 1) / kDenseTile * kDenseTile;
}

/// Inverses of the three operators in double, rounded to T and symmetric to the bit: the sweep
/// operator (Goodnight 1979) tile by tile, without pivoting.
/// @param operators  symmetric and positive definite, (3, pitch, pitch), the identity beyond row n;
///                   they are lost.
/// @return (3, n, pitch), 0 beyond column n.
/// @throws Error (resources) where the device has no room.
template <class T>
DeviceArray<T> dense_inverses(DeviceArray<double> operators, int64_t n);

/// z = A^-1 r of a level that nothing changes. The inverses are kept as their tiles on and below
/// the diagonal, each of which is read once: what it gives to its rows and what its transpose
/// gives to its columns are added in the order of the tiles.
template <class T>
class DenseSolve {
 public:
  DenseSolve() = default;
  /// @param operators  as above.
  DenseSolve(DeviceArray<double> operators, int64_t n);

  bool exists() const { return r_.size() > 0; }
  /// Where r goes, by component and node: (3, pitch), 0 beyond the last node.
  T* r() { return r_.data(); }
  /// To z of the level by slot or, where `out` is given, by node.
  void run(const StencilView<T>& level, const ResultOutput<T>& out);

 private:
  DeviceArray<T> tiles_;        // (3, pairs of tiles I >= J, kDenseTile, kDenseTile)
  DeviceArray<T> r_, sums_;     // sums: (3, I, J, kDenseTile), rows of tile I times columns of J
  DeviceArray<unsigned> done_;  // of the tiles of each I, (3, tiles); 0 between the launches
};

}  // namespace elastogen::cuda
