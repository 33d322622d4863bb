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
};

/// Eigenvalues (unsorted) and eigenvectors, the columns of Q: A = Q diag(value) Q^T.
template <class T>
struct Eigen3 {
  T value[3];
  Mat3<T> Q;
};

template <class T>
ELASTOGEN_HD inline Eigen3<T> eigen3(const Symmetric3<T>& A) {
  using S = Scalar<T>;
  T d[3] = {A.m[0], A.m[1], A.m[2]}, off[3] = {A.m[3], A.m[4], A.m[5]};
  Eigen3<T> result;
  result.Q = identity<T>();
  for (int sweep = 0; sweep < 8; ++sweep) {
    for (int p = 0; p < 3; ++p) {
      // rotate in the plane (p, q); off[p] couples p and q, the others couple them with r
      const int q = (p + 1) % 3, r = (p + 2) % 3;
      const auto open = absolute(off[p]) > std::numeric_limits<S>::min();
      const T zeta = (d[q] - d[p]) / (2 * (open ? off[p] : constant<T>(1)));
      const T size = 1 / (absolute(zeta) + square_root(1 + zeta * zeta));
      const T t = open ? (zeta < 0 ? -size : size) : constant<T>(0);
      const T c = 1 / square_root(1 + t * t), s = t * c;
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
  for (int i = 0; i < 3; ++i) result.value[i] = d[i];
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
