// SPDX-License-Identifier: Apache-2.0
// Motion of one embedded point (voxelize/embedding.hpp): formulas for host and device, with equal
// bits on both if neither contracts.

#pragma once

#include "core/base.hpp"

namespace elastogen {

/// Gradient of the weight of corner c with respect to t. A coordinate within 0..1 also moves the
/// nearest point, and with it the slopes with which the other coordinates continue.
/// @param t     place in units of the voxel.
/// @param near  nearest point of the voxel.
ELASTOGEN_HD inline void trilinear_gradient(int c, const double* t, const double* near,
                                            double* gradient) {
  double factor[3], sign[3];
  for (int d = 0; d < 3; ++d) {
    factor[d] = c >> d & 1 ? near[d] : 1 - near[d];
    sign[d] = c >> d & 1 ? 1 : -1;
  }
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    gradient[d] = sign[d] * factor[e] * factor[f];
    if (t[d] != near[d]) continue;
    gradient[d] +=
        sign[d] * (sign[e] * factor[f] * (t[e] - near[e]) + sign[f] * factor[e] * (t[f] - near[f]));
  }
}

/// d_p of a point. x, rest  [m], (nodes, 3). @param nodes  of the corners of its voxel, 8.
ELASTOGEN_HD inline void embedded_displacement(const int32_t* nodes, const double* weights,
                                               const double* x, const double* rest,
                                               double* displacement) {
  double sum[3] = {};
  for (int c = 0; c < 8; ++c) {
    const int64_t at = 3 * int64_t(nodes[c]);
    for (int d = 0; d < 3; ++d) sum[d] += weights[c] * (x[at + d] - rest[at + d]);
  }
  for (int d = 0; d < 3; ++d) displacement[d] = sum[d];
}

/// F_p of a point, row-major.
ELASTOGEN_HD inline void embedded_gradient(const int32_t* nodes, const double* weights,
                                           const double* x, const double* rest, double h,
                                           double* gradient) {
  // the weights carry linear functions exactly, so they reproduce the point's own place
  double t[3] = {}, near[3];
  bool rests = true;
  for (int c = 0; c < 8; ++c) {
    rests = rests && weights[c] == 0;
    for (int d = 0; d < 3; ++d) t[d] += (c >> d & 1) * weights[c];
  }
  for (int d = 0; d < 3; ++d) near[d] = t[d] < 0 ? 0 : t[d] > 1 ? 1 : t[d];
  double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int c = 0; c < 8 && !rests; ++c) {
    const int64_t at = 3 * int64_t(nodes[c]);
    double slope[3];
    trilinear_gradient(c, t, near, slope);
    for (int i = 0; i < 3; ++i)
      for (int d = 0; d < 3; ++d) F[3 * i + d] += (x[at + i] - rest[at + i]) * slope[d] / h;
  }
  for (int k = 0; k < 9; ++k) gradient[k] = F[k];
}

}  // namespace elastogen
