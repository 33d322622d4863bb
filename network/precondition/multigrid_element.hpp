// SPDX-License-Identifier: Apache-2.0
// Shared by the multigrid of the CPU and that of the GPU: the product of a voxel with the element
// matrix of one displacement component, and the coefficients of the Chebyshev smoother.

#pragma once

#include "core/hex8.hpp"
#include "core/pack.hpp"

namespace elastogen {

/// Product of a voxel (P scalar) or a row of voxels (P pack) with one component's element matrix,
/// divided by h. k[0..5] = phi times mu, lambda, c_xy, c_yz, c_zx, c_xyz.
template <bool kBorder, class P>
[[gnu::always_inline]] ELASTOGEN_HD inline void scalar_element(const P k[6], const P M[7],
                                                               int component, const P p[8],
                                                               P f[8]) {
  using S = Scalar<P>;
  P g[8], d[3], q[4], s[4];
  for (int c = 0; c < 8; ++c) g[c] = p[c], f[c] = P{};
  hex8::to_patterns(g);
  hex8::gradient<kBorder>(g, M, d);
  for (int e = 0; e < 3; ++e) d[e] = d[e] * (e == component ? 2 * k[0] + k[1] : k[0]) * (S(1) / 16);
  hex8::add_gradient_transposed<kBorder>(d, M, f);
  hex8::centred_patterns<kBorder>(g, M, q);
  hex8::variance(q, k + 2, s);
  hex8::add_centred_transposed<kBorder>(s, M, f);
  hex8::to_corners(f);
}

/// Largest eigenvalue of D^-1 K of a full voxel, components x, y, z together; D its diagonal.
ELASTOGEN_HD inline double element_bound(const double k[6]) {
  const double variance = (k[2] + k[3] + k[4]) / 24 + k[5] / 48;
  const double tops[] = {(2 * k[0] + k[1]) / 2, k[2] / 3, k[3] / 3, k[4] / 3, k[5] / 6};
  double top = 0;
  for (const double value : tops) top = value > top ? value : top;
  return top / ((4 * k[0] + k[1]) / 16 + variance);
}

/// Largest ratio by which border voxels exceed element_bound.
inline constexpr double kBorderExcess = 1.03;

/// Coefficients of the Chebyshev polynomial of degree 2 on [b/6, b].
struct Chebyshev {
  explicit Chebyshev(double b) {
    const double theta = (b + b / 6) / 2, delta = (b - b / 6) / 2, sigma = theta / delta;
    first = 1 / theta;
    const double rho = 1 / sigma, next = 1 / (2 * sigma - rho);
    keep = next * rho;
    add = 2 * next / delta;
  }
  double first, keep, add;
};

}  // namespace elastogen
