// SPDX-License-Identifier: Apache-2.0
// Singular value decomposition of plane deformation gradients: the plane part is decomposed, and
// the third direction stays third, for any stretch in it.

#pragma once

#include "core/svd3.hpp"

#include <cmath>

namespace elastogen {

/// F = U diag(sigma) V^T of a matrix whose third row and column are those of diag(., ., F_33):
/// U, V rotations about the third axis, sigma_0 >= |sigma_1|, sigma_1 with the sign of the plane
/// determinant, sigma_2 = F_33. The plane part is a sum of multiples of a rotation and a
/// reflection, q R(a) + r S(b), with sigma = q + r, q - r. Scalars only.
template <class T>
ELASTOGEN_HD inline Svd3<T> plane_svd(const Mat3<T>& F) {
  const T e = (F(0, 0) + F(1, 1)) / 2, f = (F(0, 0) - F(1, 1)) / 2;
  const T g = (F(1, 0) + F(0, 1)) / 2, h = (F(1, 0) - F(0, 1)) / 2;
  const T q = std::hypot(e, h), r = std::hypot(f, g);
  const T turn = q > 0 ? std::atan2(h, e) : T(0), mirror = r > 0 ? std::atan2(g, f) : T(0);
  const T left = (turn + mirror) / 2, right = (mirror - turn) / 2;
  Svd3<T> s;
  s.U = s.V = identity<T>();
  s.U(0, 0) = s.U(1, 1) = std::cos(left), s.U(1, 0) = std::sin(left), s.U(0, 1) = -s.U(1, 0);
  s.V(0, 0) = s.V(1, 1) = std::cos(right), s.V(1, 0) = std::sin(right), s.V(0, 1) = -s.V(1, 0);
  s.sigma[0] = q + r, s.sigma[1] = q - r, s.sigma[2] = F(2, 2);
  return s;
}

/// svd3, or with d = 2 plane_svd.
template <int d, class T>
ELASTOGEN_HD inline Svd3<T> decompose(const Mat3<T>& F) {
  static_assert(d == 2 || d == 3);
  if constexpr (d == 3)
    return svd3(F);
  else
    return plane_svd(F);
}

}  // namespace elastogen
