// SPDX-License-Identifier: Apache-2.0
// What the particles of a pack have, in packs.

#pragma once

#include "core/svd2.hpp"
#include "mpm_fem/mpm/transfer.hpp"

namespace elastogen::mpm {

/// Column k of the rows of a pack's particles.
inline Eight row_lanes(In<double> rows, const CellPack& pack, int k) {
  Eight value;
  for (int lane = 0; lane < kLanes; ++lane) value[lane] = rows(pack.particle[lane], k);
  return value;
}
/// The same, 0 beyond the count: for what is summed.
inline Eight counted_lanes(In<double> rows, const CellPack& pack, int k) {
  Eight value = row_lanes(rows, pack, k);
  for (int lane = pack.count; lane < kLanes; ++lane) value[lane] = 0;
  return value;
}
inline Mat3<Eight> matrix_lanes(In<double> rows, const CellPack& pack) {
  Mat3<Eight> value;
  for (int k = 0; k < 9; ++k) value.m[k] = row_lanes(rows, pack, k);
  return value;
}

inline Mat3<double> lane_of(const Mat3<Eight>& A, int lane) {
  Mat3<double> value;
  for (int k = 0; k < 9; ++k) value.m[k] = A.m[k][lane];
  return value;
}
inline void set_lane(int lane, const Mat3<double>& value, Mat3<Eight>& A) {
  for (int k = 0; k < 9; ++k) A.m[k][lane] = value.m[k];
}

/// I + G.
inline Mat3<Eight> deformed(Mat3<Eight> G) {
  for (int a = 0; a < 3; ++a) G(a, a) += 1;
  return G;
}

/// decompose of each lane.
template <int d>
Svd3<Eight> decompose_lanes(const Mat3<Eight>& F) {
  if constexpr (d == 3) {
    return svd3(F);
  } else {
    Svd3<Eight> all;
    for (int lane = 0; lane < kLanes; ++lane) {
      const Svd3<double> one = plane_svd(lane_of(F, lane));
      set_lane(lane, one.U, all.U), set_lane(lane, one.V, all.V);
      for (int i = 0; i < 3; ++i) all.sigma[i][lane] = one.sigma[i];
    }
    return all;
  }
}

}  // namespace elastogen::mpm
