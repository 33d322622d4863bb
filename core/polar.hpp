// SPDX-License-Identifier: Apache-2.0
// Rotation of the polar decomposition F = R S, from the singular value decomposition.

#pragma once

#include "core/svd3.hpp"

namespace elastogen {

/// The rotation U V^T nearest to F (nearest rotation also where det F < 0).
template <class T>
ELASTOGEN_HD inline Mat3<T> polar_rotation(const Mat3<T>& F) {
  const Svd3<T> s = svd3(F);
  return times_transposed(s.U, s.V);
}

/// The rotation that leaves axes alone, bit d: axis d, of what F does to the others.
template <class T>
ELASTOGEN_HD inline Mat3<T> polar_rotation_about(uint8_t axes, Mat3<T> F) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (axes >> i & 1 || axes >> j & 1) F(i, j) = T(i == j);
  return polar_rotation(F);
}

/// polar_rotation where F determines it beyond rounding, s_1 + s_2 > 1e-6 max(s_0, 1); else 0.
template <class T>
ELASTOGEN_HD inline Mat3<T> unique_rotation(const Mat3<T>& F) {
  const Svd3<T> s = svd3(F);
  const auto unique =
      s.sigma[1] + s.sigma[2] > Scalar<T>(1e-6) * larger(s.sigma[0], constant<T>(1));
  Mat3<T> R = times_transposed(s.U, s.V);
  for (int k = 0; k < 9; ++k) R.m[k] = unique ? R.m[k] : constant<T>(0);
  return R;
}

}  // namespace elastogen
