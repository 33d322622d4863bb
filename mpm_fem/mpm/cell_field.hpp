// SPDX-License-Identifier: Apache-2.0
// Fields of the 3^d nodes around a cell at points in it, one axis after the other.
//
// s in [-1/2, 1/2) is the distance from the middle node over h. With l_0 = 1/2 - s, l_2 = 1/2 + s
// the splines of an axis are w_0 = l_0^2/2, w_2 = l_2^2/2, w_1 = 1 - w_0 - w_2. So with e_0 = v_0 -
// v_1, e_2 = v_2 - v_1
//
//     sum w_i v_i = v_1 + w_0 e_0 + w_2 e_2,   h sum w_i' v_i = l_2 e_2 - l_0 e_0,
//     4/h sum w_i v_i (x_i - x) = h sum w_i' v_i + 2 s l_0 l_2 (e_0 + e_2).

#pragma once

#include "mpm_fem/mpm/transfer.hpp"

namespace elastogen::mpm {

/// A field at points: sum w v, its gradient, and the affine part 4/h^2 sum w v (x_i - x)^T.
template <class T>
struct FieldPack {
  T v[3] = {};
  Mat3<T> G = {}, C = {};
};

/// Positions of points of a cell along each axis.
template <int d, class T>
struct CellPoint {
  T w[d][2], l[d][2], bend[d];

  /// @param x     [m]
  /// @param base  coordinates of the first node in h
  CellPoint(const T* x, const int32_t* base, double h) {
    for (int a = 0; a < d; ++a) {
      const T s = x[a] / h - (base[a] + 1.0);
      l[a][0] = 0.5 - s, l[a][1] = 0.5 + s;
      for (int i = 0; i < 2; ++i) w[a][i] = 0.5 * l[a][i] * l[a][i];
      bend[a] = 2 * s * l[a][0] * l[a][1];
    }
  }
  /// Value from v_0 - v_1, v_1, v_2 - v_1 along axis a.
  template <class V>
  T value(int a, const V* c) const {
    return c[1] + (w[a][0] * c[0] + w[a][1] * c[2]);
  }
  template <class V>
  T slope(int a, const V* c) const {
    return l[a][1] * c[2] - l[a][0] * c[0];
  }
};

/// The nodes of a cell in differences along every axis, (3^d, kFour).
template <int d>
struct CellNodes {
  static constexpr int kCount = d == 3 ? 27 : 9;
  Four c[kCount];

  /// @param place  of the first node in the tile
  CellNodes(const double* tile, int place) {
    constexpr int w = ParticleGrid<d>::kTileWidth;
    for (int n = 0; n < kCount; ++n)
      c[n] = load<double, Four>(tile + kFour * (place + n % 3 + w * (n / 3 % 3 + w * (n / 9))));
    for (int stride = 1; stride < kCount; stride *= 3)
      for (int n = 0; n < kCount; ++n)
        if (n / stride % 3 == 1) c[n - stride] -= c[n], c[n + stride] -= c[n];
  }
};

/// One component of the field: its value, and along each axis h times the slope, and e_0 + e_2.
template <int d, class T>
void field_component(const CellNodes<d>& nodes, const CellPoint<d, T>& at, int a, T& value,
                     T slope[d], T bend[d]) {
  constexpr int kPlanes = d == 3 ? 3 : 1;
  T v[kPlanes], sx[kPlanes], sy[kPlanes], bx[kPlanes], by[kPlanes];
  for (int k = 0; k < kPlanes; ++k) {
    T row[3], row_slope[3], row_bend[3];
    for (int j = 0; j < 3; ++j) {
      const Four* n = nodes.c + 3 * (j + 3 * k);
      const double c[3] = {n[0][a], n[1][a], n[2][a]};
      row[j] = at.value(0, c), row_slope[j] = at.slope(0, c);
      row_bend[j] = constant<T>(c[0] + c[2]);
    }
    v[k] = at.value(1, row), sx[k] = at.value(1, row_slope), bx[k] = at.value(1, row_bend);
    sy[k] = at.slope(1, row), by[k] = row[0] + row[2];
  }
  if constexpr (d == 2) {
    value = v[0], slope[0] = sx[0], slope[1] = sy[0], bend[0] = bx[0], bend[1] = by[0];
  } else {
    value = at.value(2, v);
    slope[0] = at.value(2, sx), slope[1] = at.value(2, sy), slope[2] = at.slope(2, v);
    bend[0] = at.value(2, bx), bend[1] = at.value(2, by), bend[2] = v[0] + v[2];
  }
}

/// The field at the lanes of a pack from `begin` on.
template <int d, class T>
FieldPack<T> field_at(const ParticleGrid<d>& grid, const CellPack& pack, int begin,
                      const double* tile) {
  T x[3];
  for (int a = 0; a < 3; ++a) x[a] = load<double, T>(pack.x[a] + begin);
  const CellPoint<d, T> at(x, pack.base, grid.h());
  const CellNodes<d> nodes(tile, pack.place);
  FieldPack<T> r;
  for (int a = 0; a < d; ++a) {
    T slope[d], bend[d];
    field_component<d>(nodes, at, a, r.v[a], slope, bend);
    for (int b = 0; b < d; ++b) {
      r.G(a, b) = slope[b] / grid.h();
      r.C(a, b) = (slope[b] + at.bend[b] * bend[b]) / grid.h();
    }
  }
  return r;
}

}  // namespace elastogen::mpm
