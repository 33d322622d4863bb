// SPDX-License-Identifier: Apache-2.0
// Symmetric 3x3 eigenproblem by cyclic Jacobi rotations, and the projection to the nearest
// positive semi-definite matrix.

#pragma once

#include "core/mat3.hpp"

namespace elastogen {

/// Symmetric matrix stored as 00, 11, 22, 01, 12, 20.
template <class T>
struct Symmetric3 {
  T m[6];
  /// Entry of row i and column j.
  ELASTOGEN_HD const T& operator()(int i, int j) const {
    return m[i == j ? i : i + j == 1 ? 3 : i + j == 3 ? 4 : 5];
  }
};

/// Eigenvalues (unsorted) and eigenvectors, the columns of Q: A = Q diag(value) Q^T.
template <class T>
struct Eigen3 {
  T value[3];
  Mat3<T> Q;
};

namespace eigen {

template <class T>
ELASTOGEN_HD inline T size(const T a[3]) {
  return absolute(a[0]) + absolute(a[1]) + absolute(a[2]);
}

}  // namespace eigen

/// Sweeps until A is diagonal to rounding, three to five times, never more than eight; a lane of a
/// pack that is diagonal already does not change.
template <class T>
ELASTOGEN_HD inline Eigen3<T> eigen3(const Symmetric3<T>& A) {
  using S = Scalar<T>;
  const T scale = eigen::size(A.m) + eigen::size(A.m + 3);
  const T unit = scale > 0 ? scale : constant<T>(1);
  T d[3], off[3];
  for (int i = 0; i < 3; ++i) d[i] = A.m[i] / unit, off[i] = A.m[3 + i] / unit;
  Eigen3<T> result;
  result.Q = identity<T>();
  for (int sweep = 0; sweep < 8; ++sweep) {
    const auto wide = eigen::size(off) > std::numeric_limits<S>::epsilon() * eigen::size(d);
    if (!any(wide)) break;
    for (int p = 0; p < 3; ++p) {
      // rotate in the plane (p, q); off[p] couples p and q, the others couple them with r
      const int q = (p + 1) % 3, r = (p + 2) % 3;
      const T a = d[q] - d[p], b = 2 * off[p];
      const T root = square_root(a * a + b * b);
      const auto open = decltype(a < b)(wide & (root > 0));
      const T h = open ? root : constant<T>(1);
      // tan 2x = b/a, |x| <= 45 degrees
      const T t = open ? (a < 0 ? -b : b) / (absolute(a) + h) : constant<T>(0);
      const T c = open ? square_root((1 + absolute(a) / h) / 2) : constant<T>(1), s = t * c;
      d[p] -= t * off[p];
      d[q] += t * off[p];
      off[p] = open ? constant<T>(0) : off[p];
      const T pr = off[r], qr = off[q];  // off[r] couples r and p, off[q] couples q and r
      off[r] = c * pr - s * qr;
      off[q] = s * pr + c * qr;
      for (int i = 0; i < 3; ++i) {
        const T v = result.Q(i, p);
        result.Q(i, p) = c * v - s * result.Q(i, q);
        result.Q(i, q) = s * v + c * result.Q(i, q);
      }
    }
  }
  for (int i = 0; i < 3; ++i) result.value[i] = d[i] * unit;
  return result;
}

/// A with its negative eigenvalues set to 0. Unchanged to the bit where there are none.
template <class T>
ELASTOGEN_HD inline Symmetric3<T> positive_part(const Symmetric3<T>& A) {
  const Eigen3<T> e = eigen3(A);
  Symmetric3<T> result = A;
  for (int k = 0; k < 3; ++k) {
    const T excess = e.value[k] < 0 ? -e.value[k] : constant<T>(0);
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      result.m[i] += excess * e.Q(i, k) * e.Q(i, k);
      result.m[3 + i] += excess * e.Q(i, k) * e.Q(j, k);
    }
  }
  return result;
}

}  // namespace elastogen
