// SPDX-License-Identifier: Apache-2.0
// 3x3 algebra on row-major matrices of scalars or packs.

#pragma once

#include "core/pack.hpp"

namespace elastogen {

/// Row-major 3x3 matrix.
template <class T>
struct Mat3 {
  T m[9];
  ELASTOGEN_HD T& operator()(int i, int j) { return m[3 * i + j]; }
  ELASTOGEN_HD const T& operator()(int i, int j) const { return m[3 * i + j]; }
};

template <class T>
ELASTOGEN_HD inline Mat3<T> identity() {
  Mat3<T> I{};
  for (int i = 0; i < 3; ++i) I(i, i) = constant<T>(1);
  return I;
}

/// A B
template <class T>
ELASTOGEN_HD inline Mat3<T> operator*(const Mat3<T>& A, const Mat3<T>& B) {
  Mat3<T> C;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) C(i, j) = A(i, 0) * B(0, j) + A(i, 1) * B(1, j) + A(i, 2) * B(2, j);
  return C;
}

/// A^T B
template <class T>
ELASTOGEN_HD inline Mat3<T> transposed_times(const Mat3<T>& A, const Mat3<T>& B) {
  Mat3<T> C;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) C(i, j) = A(0, i) * B(0, j) + A(1, i) * B(1, j) + A(2, i) * B(2, j);
  return C;
}

/// A B^T
template <class T>
ELASTOGEN_HD inline Mat3<T> times_transposed(const Mat3<T>& A, const Mat3<T>& B) {
  Mat3<T> C;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) C(i, j) = A(i, 0) * B(j, 0) + A(i, 1) * B(j, 1) + A(i, 2) * B(j, 2);
  return C;
}

template <class T>
ELASTOGEN_HD inline T determinant(const Mat3<T>& A) {
  return A(0, 0) * (A(1, 1) * A(2, 2) - A(1, 2) * A(2, 1)) -
         A(0, 1) * (A(1, 0) * A(2, 2) - A(1, 2) * A(2, 0)) +
         A(0, 2) * (A(1, 0) * A(2, 1) - A(1, 1) * A(2, 0));
}

/// Cofactor of A, det A A^-T: the derivative of det A.
template <class T>
ELASTOGEN_HD inline Mat3<T> cofactor(const Mat3<T>& A) {
  Mat3<T> C;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      C(i, j) = A(i1, j1) * A(i2, j2) - A(i1, j2) * A(i2, j1);
    }
  return C;
}

/// A^-1; not finite where det A is 0.
template <class T>
ELASTOGEN_HD inline Mat3<T> inverse(const Mat3<T>& A) {
  const Mat3<T> C = cofactor(A);
  const T J = determinant(A);
  Mat3<T> R;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R(i, j) = C(j, i) / J;
  return R;
}

/// A from nine numbers, row by row.
template <class T>
ELASTOGEN_HD inline Mat3<T> load_matrix(const T* from) {
  Mat3<T> A;
  for (int k = 0; k < 9; ++k) A.m[k] = from[k];
  return A;
}
template <class T>
ELASTOGEN_HD inline void store_matrix(const Mat3<T>& A, T* to) {
  for (int k = 0; k < 9; ++k) to[k] = A.m[k];
}

/// F = I + H.
template <class T>
ELASTOGEN_HD inline Mat3<T> plus_identity(const Mat3<T>& H) {
  Mat3<T> F = H;
  for (int i = 0; i < 3; ++i) F(i, i) = F(i, i) + 1;
  return F;
}

}  // namespace elastogen
