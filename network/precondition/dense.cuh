// SPDX-License-Identifier: Apache-2.0
// The coarsest level of the V-cycle, which is solved: inverses of its dense operators A_d, and
// z_d = A_d^-1 r_d by the whole card.

#pragma once

#include "core/cuda/array.cuh"
#include "network/precondition/stencil.cuh"

namespace elastogen::cuda {

inline constexpr int kDenseTile = 64;     ///< rows of the tiles of a matrix
inline constexpr int kDenseMatrices = 3;  ///< one an axis

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

/// Tiles on and below the diagonal, row by row, and which the one of a number is.
ELASTOGEN_HD inline int64_t tile_pairs(int64_t tiles) {
  return tiles * (tiles + 1) / 2;
}
__device__ inline void find_tile(int pair, int& I, int& J) {
  I = int((sqrtf(8 * float(pair) + 1) - 1) / 2);
  while (tile_pairs(I + 1) <= pair) ++I;
  while (tile_pairs(I) > pair) --I;
  J = pair - int(tile_pairs(I));
}

/// The same as the tiles on and below the diagonal alone, row by row, (3, tile_pairs, kDenseTile,
/// kDenseTile), 0 beyond row and column n. All is there when it returns: who reads them need not
/// wait for kernels before.
template <class T>
DeviceArray<T> dense_inverse_tiles(DeviceArray<double> operators, int64_t n);

/// z = A^-1 r of a level that nothing changes. The inverses are kept as their tiles on and below
/// the diagonal, each of which is read once: what it gives to its rows and what its transpose
/// gives to its columns are added in the order of the tiles.
template <class T>
class DenseSolve {
 public:
  DenseSolve() = default;
  /// @param operators  as above.
  DenseSolve(DeviceArray<double> operators, int64_t n);

  bool exists() const { return tile_count_ > 0; }
  /// To z of the level by slot or, where `out` is given, by node.
  /// @param partial  of the finer level, which r comes from; nullptr: r is that of the level.
  void run(const StencilView<T>& level, const T* partial, const ResultOutput<T>& out,
           const Line& line);

 private:
  DeviceArray<T> tiles_;  // (3, pairs of tiles I >= J, kDenseTile, kDenseTile)
  DeviceArray<T> sums_;   // (3, I, J, kDenseTile), rows of tile I times columns of tile J
  int tile_count_ = 0;    // of a row
  int blocks_ = 0;        // as many as the card holds, or one a tile
};

}  // namespace elastogen::cuda
