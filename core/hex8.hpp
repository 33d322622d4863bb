// SPDX-License-Identifier: Apache-2.0
// Kinematics of a voxel: a trilinear hexahedron of edge h with one deformation gradient (ElastoGen,
// Eq. 8), taken as the mean over its filled part, and the strain-variance (hourglass) term that
// holds what one gradient cannot see. Maths of one voxel (T scalar) or of a row of eight (T pack).
//
// Corner c = i + 2 j + 4 k lies on the + side of axis d when bit d of c is set; s_cd = +-1. The
// eight pattern sums of corner values u_c,
//
//     g_p = sum_c u_c prod_{d in p} s_cd,     p a set of axes as bits: x 1, y 2, z 4,
//
// carry everything: g_1, g_2, g_4 the centre gradient, g_3 (xy), g_6 (yz), g_5 (zx), g_7 (xyz) the
// twelve modes that the centre does not see. With M_p = sum_c Nbar_c prod_{d in p} s_cd of the
// shape function means Nbar_c over the fill (all 0 in a full voxel), the mean gradient is
//
//     du/dX_x = (g_1 + M_2 g_3 + M_4 g_5 + M_6 g_7) / (4 h)      and cyclic,
//
// and the patterns re-centred at the centroid of the fill are g_3 + M_4 g_7 and cyclic.

#pragma once

#include "core/mat3.hpp"

namespace elastogen::hex8 {

/// Pattern index of xy, yz, zx, xyz, in the order of Scene::variance and the state file.
ELASTOGEN_HD constexpr int pattern(int k) {
  return k == 0 ? 3 : k == 1 ? 6 : k == 2 ? 5 : 7;
}

/// Corner values to pattern sums, in place (Walsh-Hadamard transform).
template <class T>
ELASTOGEN_HD inline void to_patterns(T v[8]) {
  for (int bit = 1; bit < 8; bit *= 2)
    for (int c = 0; c < 8; ++c)
      if (!(c & bit)) {
        const T low = v[c], high = v[c | bit];
        v[c] = high + low;
        v[c | bit] = high - low;
      }
}

/// The transpose of to_patterns: derivatives in pattern sums to derivatives in corner values.
template <class T>
ELASTOGEN_HD inline void to_corners(T v[8]) {
  for (int bit = 1; bit < 8; bit *= 2)
    for (int c = 0; c < 8; ++c)
      if (!(c & bit)) {
        const T sum = v[c], difference = v[c | bit];
        v[c] = sum - difference;
        v[c | bit] = sum + difference;
      }
}

/// Moments M_1 ... M_6 of the fill from the means of the shape functions; M[0] is unused.
template <class T>
ELASTOGEN_HD inline void fill_moments(const T shape_mean[8], T M[7]) {
  T v[8];
  for (int c = 0; c < 8; ++c) v[c] = shape_mean[c];
  to_patterns(v);
  for (int p = 0; p < 7; ++p) M[p] = v[p];
}

/// Gradient of one component from its pattern sums, times 4 h.
template <bool kBorder, class T>
ELASTOGEN_HD inline void gradient(const T g[8], const T M[7], T result[3]) {
  result[0] = g[1], result[1] = g[2], result[2] = g[4];
  if constexpr (kBorder) {
    result[0] += M[2] * g[3] + M[4] * g[5] + M[6] * g[7];
    result[1] += M[1] * g[3] + M[4] * g[6] + M[5] * g[7];
    result[2] += M[1] * g[5] + M[2] * g[6] + M[3] * g[7];
  }
}

/// The transpose of gradient, added to g.
template <bool kBorder, class T>
ELASTOGEN_HD inline void add_gradient_transposed(const T d[3], const T M[7], T g[8]) {
  g[1] += d[0], g[2] += d[1], g[4] += d[2];
  if constexpr (kBorder) {
    g[3] += M[2] * d[0] + M[1] * d[1];
    g[5] += M[4] * d[0] + M[1] * d[2];
    g[6] += M[4] * d[1] + M[2] * d[2];
    g[7] += M[6] * d[0] + M[5] * d[1] + M[3] * d[2];
  }
}

/// The re-centred patterns xy, yz, zx, xyz of one component.
template <bool kBorder, class T>
ELASTOGEN_HD inline void centred_patterns(const T g[8], const T M[7], T result[4]) {
  for (int k = 0; k < 4; ++k) result[k] = g[pattern(k)];
  if constexpr (kBorder) {
    result[0] += M[4] * g[7];
    result[1] += M[1] * g[7];
    result[2] += M[2] * g[7];
  }
}

/// The transpose of centred_patterns, added to g.
template <bool kBorder, class T>
ELASTOGEN_HD inline void add_centred_transposed(const T q[4], const T M[7], T g[8]) {
  for (int k = 0; k < 4; ++k) g[pattern(k)] += q[k];
  if constexpr (kBorder) g[7] += M[4] * q[0] + M[1] * q[1] + M[2] * q[2];
}

/// Strain-variance energy of one component's centred patterns q, divided by phi h, and its
/// gradient:
///
///     1/2 [ (c_xy q_xy^2 + c_yz q_yz^2 + c_zx q_zx^2) / 24 + c_xyz q_xyz^2 / 48 ].
///
/// It is c/2 times the integral of |F(X) - F_centre|^2 over the full voxel; zero on affine fields.
template <class T>
ELASTOGEN_HD inline T variance(const T q[4], const T c[4], T slope[4]) {
  using S = Scalar<T>;
  T energy{};
  for (int k = 0; k < 4; ++k) {
    slope[k] = c[k] * q[k] * (k < 3 ? S(1) / 24 : S(1) / 48);
    energy += slope[k] * q[k] / 2;
  }
  return energy;
}

/// Corotated torsion correction, divided by phi h: the exact energy of the three twisting modes in
/// place of that of the variance term,
///
///     1/96 [ mu ((a+b)^2 + (b+d)^2 + (d+a)^2) - 2 (c_yz a^2 + c_zx b^2 + c_xy d^2) ],
///     a = (R^T q_yz)_x,  b = (R^T q_zx)_y,  d = (R^T q_xy)_z,
///
/// R the voxel's rotation at the start of the step. q holds the centred patterns of the components
/// x, y, z; the gradient is added to slope.
template <class T>
ELASTOGEN_HD inline T torsion(const T q[3][4], const T c[4], const T& mu, const T R[9],
                              T slope[3][4]) {
  using S = Scalar<T>;
  constexpr int kPattern[3] = {1, 2, 0};  // yz, zx, xy in the order of q
  T a[3], weight[3], force[3];
  for (int d = 0; d < 3; ++d) {
    const int k = kPattern[d];
    a[d] = R[d] * q[0][k] + R[3 + d] * q[1][k] + R[6 + d] * q[2][k];
    weight[d] = c[k];
  }
  const T sum = a[0] + a[1] + a[2];
  T energy{};
  for (int d = 0; d < 3; ++d) {
    // d/da of mu ((a+b)^2 + (b+d)^2 + (d+a)^2) is 2 mu (a + (a + b + d))
    force[d] = (mu * (a[d] + sum) - 2 * weight[d] * a[d]) * (S(1) / 48);
    energy += force[d] * a[d] / 2;
  }
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < 3; ++i) slope[i][kPattern[d]] += R[3 * i + d] * force[d];
  return energy;
}

}  // namespace elastogen::hex8
