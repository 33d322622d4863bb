// SPDX-License-Identifier: Apache-2.0
// Rotation-variant singular value decomposition of 3x3 matrices: F = U diag(sigma) V^T with two
// rotations, sigma_0 >= sigma_1 >= |sigma_2|, the smallest stretch carrying the sign of det F.
//
// One-sided Jacobi (Hestenes 1958): columns of F V are rotated until they are orthogonal. Unlike
// the route by F^T F it loses nothing to squaring: reconstruction and orthogonality hold to a few
// eps for every rank and scale.

#pragma once

#include "core/mat3.hpp"

#include <limits>

namespace elastogen {

template <class T>
struct Svd3 {
  Mat3<T> U;
  T sigma[3];
  Mat3<T> V;
};

namespace svd {

/// Rotates columns p and q of B and V so that those of B become orthogonal; returns whether they
/// already were, to rounding.
template <class T>
ELASTOGEN_HD inline bool rotate(Mat3<T>& B, Mat3<T>& V, int p, int q) {
  using S = Scalar<T>;
  constexpr S kEps = std::numeric_limits<S>::epsilon(), kTiny = std::numeric_limits<S>::min();
  const T pp = B(0, p) * B(0, p) + B(1, p) * B(1, p) + B(2, p) * B(2, p);
  const T qq = B(0, q) * B(0, q) + B(1, q) * B(1, q) + B(2, q) * B(2, q);
  const T pq = B(0, p) * B(0, q) + B(1, p) * B(1, q) + B(2, p) * B(2, q);
  const auto open = pq * pq > kEps * kEps * pp * qq + kTiny;
  if (!any(open)) return true;

  // rounding of t leaves a little of pq, rounding of c would spoil the rotation
  const T zeta = rough_quotient(T(qq - pp), T(2 * (open ? pq : constant<T>(1))));
  const T size = rough_quotient(constant<T>(1), T(absolute(zeta) + square_root(1 + zeta * zeta)));
  const T t = open ? (zeta < 0 ? -size : size) : constant<T>(0);
  const T c = inverse_root(T(1 + t * t)), s = c * t;
  for (int i = 0; i < 3; ++i) {
    const T b = B(i, p), v = V(i, p);
    B(i, p) = c * b - s * B(i, q);
    B(i, q) = s * b + c * B(i, q);
    V(i, p) = c * v - s * V(i, q);
    V(i, q) = s * v + c * V(i, q);
  }
  return false;
}

/// Exchanges columns p and q where that sorts their lengths; one changes its sign, so that V stays
/// a rotation.
template <class T>
ELASTOGEN_HD inline void sort(Mat3<T>& B, Mat3<T>& V, T length[3], int p, int q) {
  const auto swap = length[p] < length[q];
  const T lp = length[p];
  length[p] = swap ? length[q] : lp;
  length[q] = swap ? lp : length[q];
  for (int i = 0; i < 3; ++i) {
    const T b = B(i, p), v = V(i, p);
    B(i, p) = swap ? B(i, q) : b;
    B(i, q) = swap ? -b : B(i, q);
    V(i, p) = swap ? V(i, q) : v;
    V(i, q) = swap ? -v : V(i, q);
  }
}

/// A unit vector orthogonal to the unit vector a.
template <class T>
ELASTOGEN_HD inline void orthogonal(const T a[3], T result[3]) {
  using S = Scalar<T>;
  const auto flat = a[2] * a[2] < S(0.5);
  const T x = flat ? -a[1] : constant<T>(0), y = flat ? a[0] : -a[2];
  const T z = flat ? constant<T>(0) : a[1];
  const T scale = inverse_root(T(x * x + y * y + z * z));
  result[0] = x * scale, result[1] = y * scale, result[2] = z * scale;
}

/// U and sigma from the orthogonal, sorted columns of B.
template <class T>
ELASTOGEN_HD inline void orthonormalise(const Mat3<T>& B, Mat3<T>& U, T sigma[3]) {
  using S = Scalar<T>;
  constexpr S kTiny = 16 * std::numeric_limits<S>::min();
  T a[3], b[3], fallback[3];
  const T aa = B(0, 0) * B(0, 0) + B(1, 0) * B(1, 0) + B(2, 0) * B(2, 0);
  const auto has_a = aa > kTiny;
  const T inverse_a = inverse_root(has_a ? aa : constant<T>(1));
  a[0] = has_a ? B(0, 0) * inverse_a : constant<T>(1);
  a[1] = has_a ? B(1, 0) * inverse_a : constant<T>(0);
  a[2] = has_a ? B(2, 0) * inverse_a : constant<T>(0);

  const T along = a[0] * B(0, 1) + a[1] * B(1, 1) + a[2] * B(2, 1);
  for (int i = 0; i < 3; ++i) b[i] = B(i, 1) - along * a[i];
  const T bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
  const auto has_b = bb > kTiny;
  const T inverse_b = inverse_root(has_b ? bb : constant<T>(1));
  orthogonal(a, fallback);
  for (int i = 0; i < 3; ++i) b[i] = has_b ? b[i] * inverse_b : fallback[i];

  const T c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  for (int i = 0; i < 3; ++i) U(i, 0) = a[i], U(i, 1) = b[i], U(i, 2) = c[i];
  for (int j = 0; j < 3; ++j) sigma[j] = U(0, j) * B(0, j) + U(1, j) * B(1, j) + U(2, j) * B(2, j);
}

}  // namespace svd

/// Decomposes F; sweeps until the columns are orthogonal to rounding (three to six, never more than
/// twelve). Finite for every finite F, also of rank 0.
template <class T>
ELASTOGEN_HD inline Svd3<T> svd3(const Mat3<T>& F) {
  // the largest entry becomes 1, so that squares neither overflow nor vanish
  T largest = absolute(F.m[0]);
  for (int k = 1; k < 9; ++k) largest = larger(largest, absolute(F.m[k]));
  largest = largest > 0 ? largest : constant<T>(1);

  Mat3<T> B;
  for (int k = 0; k < 9; ++k) B.m[k] = F.m[k] / largest;
  Svd3<T> result;
  result.V = identity<T>();
  for (int sweep = 0; sweep < 12; ++sweep) {
    const bool a = svd::rotate(B, result.V, 0, 1);
    const bool b = svd::rotate(B, result.V, 1, 2);
    const bool c = svd::rotate(B, result.V, 0, 2);
    if (a && b && c) break;
  }

  T length[3];
  for (int j = 0; j < 3; ++j) length[j] = B(0, j) * B(0, j) + B(1, j) * B(1, j) + B(2, j) * B(2, j);
  svd::sort(B, result.V, length, 0, 1);
  svd::sort(B, result.V, length, 1, 2);
  svd::sort(B, result.V, length, 0, 1);
  svd::orthonormalise(B, result.U, result.sigma);
  for (int j = 0; j < 3; ++j) result.sigma[j] = result.sigma[j] * largest;
  return result;
}

}  // namespace elastogen
