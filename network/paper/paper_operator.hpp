// SPDX-License-Identifier: Apache-2.0
// The operator of the published algorithm's RNN-2 in one voxel: the stress of the frozen quadratic
// and the diagonal of its sweeps (paper_solver.hpp).

#pragma once

#include "network/paper/paper_model.hpp"

namespace elastogen {

/// d N N^T for a row d of the gradient.
template <class T>
ELASTOGEN_HD inline void times_slope(const T NN[6], const T d[3], T result[3]) {
  result[0] = d[0] * NN[0] + d[1] * NN[3] + d[2] * NN[5];
  result[1] = d[0] * NN[3] + d[1] * NN[1] + d[2] * NN[4];
  result[2] = d[0] * NN[5] + d[1] * NN[4] + d[2] * NN[2];
}

/// Stress of the lagged quadratic, omega (dF N N^T + rest), with rest only if kAffine; dF is the
/// gradient of the motion times 4 h, and the result has this factor too.
template <bool kAffine, class T>
ELASTOGEN_HD inline void lagged_stress(Scalar<T> h, Scalar<T> omega, const T NN[6], const T rest[9],
                                       const T dF[9], T dP[9]) {
  for (int i = 0; i < 3; ++i) {
    times_slope(NN, dF + 3 * i, dP + 3 * i);
    for (int j = 0; j < 3; ++j) {
      const int k = 3 * i + j;
      if constexpr (kAffine) dP[k] += 4 * h * rest[k];
      dP[k] = omega * dP[k];
    }
  }
}

/// Shares of a voxel's corners in the diagonal D of RNN-2's sweeps [N/m] (paper_solver.hpp). With
/// the variance term a full voxel has its majorant and a border voxel the absolute row sums;
/// without it both have the diagonal itself.
template <class S>
ELASTOGEN_HD inline void diagonal_shares(const VoxelData<S>& v, bool border, const S NN[6],
                                         S largest_slope, S share[8]) {
  const S omega = lagged_weight(v.law);
  const bool variance = v.hourglass != Hourglass::kOff;
  // the majorant of a full voxel
  if (!border && variance) {
    S kappa = largest_slope;
    for (int k = 0; k < 4; ++k) kappa = larger(kappa, S(v.c[k] / omega));
    for (int c = 0; c < 8; ++c)
      share[c] = v.phi * omega * v.h * (S(3.0 / 16) * largest_slope + S(7.0 / 48) * kappa);
    return;
  }
  // gradient and patterns of a unit displacement of each corner
  S D[8][3], q[8][4], M[7];
  for (int p = 0; p < 7; ++p) M[p] = border ? v.M[p] : S(0);
  for (int c = 0; c < 8; ++c) {
    S g[8] = {};
    g[c] = 1;
    hex8::to_patterns(g);
    hex8::gradient<true>(g, M, D[c]);  // times 4 h
    hex8::centred_patterns<true>(g, M, q[c]);
  }
  // absolute row sums, or the diagonal
  for (int c = 0; c < 8; ++c) {
    S sum = 0, along[3];
    times_slope(NN, D[c], along);
    for (int e = 0; e < 8; ++e) {
      if (!variance && e != c) continue;
      S entry = omega / 16 * (along[0] * D[e][0] + along[1] * D[e][1] + along[2] * D[e][2]);
      for (int k = 0; k < 4 && variance; ++k)
        entry += v.c[k] * q[c][k] * q[e][k] / (k < 3 ? 24 : 48);
      sum += entry < 0 ? -entry : entry;
    }
    share[c] = v.phi * v.h * sum;
  }
}

}  // namespace elastogen
