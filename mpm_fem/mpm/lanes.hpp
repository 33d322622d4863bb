// SPDX-License-Identifier: Apache-2.0
// Values of the particles of a pack, in packs.

#pragma once

#include "core/svd2.hpp"
#include "mpm_fem/mpm/transfer.hpp"

#include <algorithm>

namespace elastogen::mpm {

/// Column k of the rows of a pack's particles, of all or from the lane `begin` on.
template <class T = Eight>
T row_lanes(In<double> rows, const CellPack& pack, int k, int begin = 0) {
  T value;
  for (int lane = 0; lane < lane_count<T>; ++lane)
    value[lane] = rows(pack.particle[begin + lane], k);
  return value;
}
/// row_lanes with 0 beyond the count, for sums.
template <class T = Eight>
T counted_lanes(In<double> rows, const CellPack& pack, int k, int begin = 0) {
  T value = row_lanes<T>(rows, pack, k, begin);
  for (int lane = std::max(0, pack.count - begin); lane < lane_count<T>; ++lane) value[lane] = 0;
  return value;
}
template <class T = Eight>
Mat3<T> matrix_lanes(In<double> rows, const CellPack& pack, int begin = 0) {
  Mat3<T> value;
  for (int k = 0; k < 9; ++k) value.m[k] = row_lanes<T>(rows, pack, k, begin);
  return value;
}
/// Lanes of a pack from `begin` on.
template <class T>
T part(const Eight& all, int begin) {
  return load<double, T>(reinterpret_cast<const double*>(&all) + begin);
}

template <class T>
Mat3<T> part(const Mat3<Eight>& all, int begin) {
  Mat3<T> value;
  for (int k = 0; k < 9; ++k) value.m[k] = part<T>(all.m[k], begin);
  return value;
}

/// Prefetches the rows of the particles of pack k, which need not lie together.
template <int d, class... Rows>
void fetch_ahead(const ParticleGrid<d>& g, size_t k, const Rows&... rows) {
  if (k >= g.packs().size()) return;
  const CellPack& pack = g.packs()[k];
  const auto fetch = [&](const Array<double>& all) {
    for (int lane = 0; lane < pack.count; ++lane) {
      const double* row = all.row(pack.particle[lane]);
      __builtin_prefetch(row);
      if (all.cols() > 1) __builtin_prefetch(row + all.cols() - 1);
    }
  };
  (fetch(rows), ...);
}

template <class T>
Mat3<double> lane_of(const Mat3<T>& A, int lane) {
  Mat3<double> value;
  for (int k = 0; k < 9; ++k) value.m[k] = A.m[k][lane];
  return value;
}
template <class T>
void set_lane(int lane, const Mat3<double>& value, Mat3<T>& A) {
  for (int k = 0; k < 9; ++k) A.m[k][lane] = value.m[k];
}

/// I + G.
template <class T>
Mat3<T> deformed(Mat3<T> G) {
  for (int a = 0; a < 3; ++a) G(a, a) += 1;
  return G;
}

/// decompose of each lane.
template <int d, class T>
Svd3<T> decompose_lanes(const Mat3<T>& F) {
  if constexpr (d == 3) {
    return svd3(F);
  } else {
    Svd3<T> all;
    for (int lane = 0; lane < lane_count<T>; ++lane) {
      const Svd3<double> one = plane_svd(lane_of(F, lane));
      set_lane(lane, one.U, all.U), set_lane(lane, one.V, all.V);
      for (int i = 0; i < 3; ++i) all.sigma[i][lane] = one.sigma[i];
    }
    return all;
  }
}

}  // namespace elastogen::mpm
