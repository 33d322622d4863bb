// SPDX-License-Identifier: Apache-2.0
// The coarsest level of the V-cycle, which is solved directly: inverses of its dense operators A_d,
// one for each component d, and z_d = A_d^-1 r_d by the whole card.

#pragma once

#include "core/cuda/array.cuh"
#include "network/precondition/stencil.cuh"

namespace elastogen::cuda {

inline constexpr int kDenseTile = 64;     ///< rows of the tiles of a matrix
inline constexpr int kDenseMatrices = 3;  ///< one for each axis

/// Pitch of the rows of a matrix of n rows: n rounded up to whole tiles.
inline int64_t dense_pitch(int64_t n) {
  return (n + kDenseTile - 1) / kDenseTile * kDenseTile;
}

/// Inverses of the three operators in double, rounded to T and symmetric to the bit: the sweep
/// operator (Goodnight 1979) tile by tile, without pivoting.
/// @param operators  symmetric and positive definite, (3, pitch, pitch), the identity beyond row n;
///                   the sweep overwrites them.
/// @return (3, n, pitch), 0 beyond column n.
/// @throws Error (resources) if the device has too little memory.
template <class T>
DeviceArray<T> dense_inverses(DeviceArray<double> operators, int64_t n);

/// Count of the tiles on and below the diagonal, and row I and column J of the tile of a number;
/// tiles are numbered row by row.
ELASTOGEN_HD inline int64_t tile_pairs(int64_t tiles) {
  return tiles * (tiles + 1) / 2;
}
__device__ inline void find_tile(int pair, int& I, int& J) {
  I = int((sqrtf(8 * float(pair) + 1) - 1) / 2);
  while (tile_pairs(I + 1) <= pair) ++I;
  while (tile_pairs(I) > pair) --I;
  J = pair - int(tile_pairs(I));
}

/// The inverses of dense_inverses as their tiles on and below the diagonal, row by row,
/// (3, tile_pairs, kDenseTile, kDenseTile), 0 beyond row and column n. They are complete when this
/// returns, so that kernels may read them before they wait for earlier kernels.
template <class T>
DeviceArray<T> dense_inverse_tiles(DeviceArray<double> operators, int64_t n);

/// z = A^-1 r of a level whose operators never change. It stores the tiles of the inverses on and
/// below the diagonal and reads each once, for its product with r and for the product of its
/// transpose. The products are added in the order of the tiles.
template <class T>
class DenseSolve {
 public:
  DenseSolve() = default;
  /// @param operators  as above.
  DenseSolve(DeviceArray<double> operators, int64_t n);

  bool exists() const { return tile_count_ > 0; }
  /// Writes z to the level by slot or, where `out` has an array, to that by node.
  /// @param partial  partial sums of the finer level, from which r is made; nullptr: the level has
  ///                 r.
  void run(const StencilView<T>& level, const T* partial, const ResultOutput<T>& out,
           const LaunchOptions& options);

 private:
  DeviceArray<T> tiles_;  // (3, pairs of tiles I >= J, kDenseTile, kDenseTile)
  DeviceArray<T> sums_;   // (3, I, J, kDenseTile), rows of tile I times columns of tile J
  int tile_count_ = 0;    // tiles in a row of a matrix
  int blocks_ = 0;        // as many as the card holds at a time, or one for each tile
};

}  // namespace elastogen::cuda
