// SPDX-License-Identifier: Apache-2.0
// Quadratic B-splines on a grid of spacing h: the 3^d nodes around a point, with weights and
// gradients. With t the distance from a node over h
//
//     w = 3/4 - t^2 (|t| < 1/2),   (3/2 - |t|)^2/2 (|t| < 3/2),   0 beyond;
//
// weights of several directions multiply. They sum to 1, and sum w_i x_i = x, so that affine fields
// are reproduced exactly; sum w_i (x_i - x)(x_i - x)^T = h^2/4 I.

#pragma once

#include "core/base.hpp"

#include <cmath>
#include <cstdint>

namespace elastogen::mpm {

/// Weights along each axis for the nodes base, base + 1, base + 2, of a point or of a pack of
/// points that share these nodes.
template <int d, class T = double>
struct Spline {
  int32_t base[3] = {};
  T w[d][3];  ///< [-]
  T g[d][3];  ///< dw/dx [1/m]
  T r[d][3];  ///< node - point [m]
};

/// First of the three nodes that a coordinate x/h touches.
ELASTOGEN_HD inline int32_t first_node(double x_over_h) {
  return int32_t(std::floor(x_over_h - 0.5));
}

/// @param x     the point [m]; nodes are at the multiples of h
/// @param base  first_node of its coordinates
template <int d, class T>
ELASTOGEN_HD inline Spline<d, T> spline(const T* x, const int32_t* base, double h) {
  Spline<d, T> s;
  for (int a = 0; a < d; ++a) {
    s.base[a] = base[a];
    const T t = x[a] / h - base[a];  // in [1/2, 3/2)
    s.w[a][0] = 0.5 * (1.5 - t) * (1.5 - t);
    s.w[a][1] = 0.75 - (t - 1) * (t - 1);
    s.w[a][2] = 0.5 * (t - 0.5) * (t - 0.5);
    s.g[a][0] = (t - 1.5) / h;
    s.g[a][1] = -2 * (t - 1) / h;
    s.g[a][2] = (t - 0.5) / h;
    for (int i = 0; i < 3; ++i) s.r[a][i] = (i - t) * h;
  }
  return s;
}
template <int d>
ELASTOGEN_HD inline Spline<d> spline(const double* x, double h) {
  int32_t base[3] = {};
  for (int a = 0; a < d; ++a) base[a] = first_node(x[a] / h);
  return spline<d, double>(x, base, h);
}

/// Calls visit(place, w, g, r) for the 3^d nodes: their place in a tile of width kWidth, weight,
/// gradient and node - point.
/// @param place  of the first node
template <int d, int kWidth, class T, class Visit>
ELASTOGEN_HD inline void for_nodes(const Spline<d, T>& s, int place, const Visit& visit) {
  if constexpr (d == 2) {
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        const T g[3] = {s.g[0][i] * s.w[1][j], s.w[0][i] * s.g[1][j], T{}};
        const T r[3] = {s.r[0][i], s.r[1][j], T{}};
        visit(place + i + kWidth * j, T(s.w[0][i] * s.w[1][j]), g, r);
      }
  } else {
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) {
        const T wjk = s.w[1][j] * s.w[2][k];
        const T gj = s.g[1][j] * s.w[2][k], gk = s.w[1][j] * s.g[2][k];
        for (int i = 0; i < 3; ++i) {
          const T g[3] = {s.g[0][i] * wjk, s.w[0][i] * gj, s.w[0][i] * gk};
          const T r[3] = {s.r[0][i], s.r[1][j], s.r[2][k]};
          visit(place + i + kWidth * (j + kWidth * k), T(s.w[0][i] * wjk), g, r);
        }
      }
  }
}

}  // namespace elastogen::mpm
