// SPDX-License-Identifier: Apache-2.0
// Isotropic functions of a symmetric 3x3 matrix from its eigenvalues alone, without eigenvectors:
//
//     A = m I + p B,  m = tr A/3,  tr B = 0,  tr B^2 = 6,      eigenvalues m + p t_i,
//     cos 3x = |det B|/2,  t_1 = +-2 cos x,  t_2, t_3 = -t_1/2 +- sqrt 3 sin x      (Viete),
//
// t_1 is apart from the others, which may be equal. sum_i f_i v_i v_i^T is the polynomial in B that
// is f_i at t_i. Where t_2 and t_3 are close their distance has an error of sqrt eps. Where f is a
// smooth symmetric function of both, the polynomial is even in that distance and loses some eps
// only.

#pragma once

#include "core/eigen3.hpp"

namespace elastogen {

template <class T>
struct Spectrum3 {
  T mean, scale;       ///< m, p
  Symmetric3<T> unit;  ///< B; 0 where p is
  T t[3];

  ELASTOGEN_HD T value(int i) const { return mean + scale * t[i]; }
  /// sum_i f_i v_i v_i^T.
  ELASTOGEN_HD Symmetric3<T> isotropic(const T f[3]) const;
};

namespace spectrum {

/// cos x of cos 3x = r in [0, 1]: the largest root of f = 4 c^3 - 3 c - r, by a step of Halley's
/// method, of third order, from a polynomial that is within 5e-6 of it.
template <class T>
ELASTOGEN_HD inline T cosine_of_third(const T& r) {
  using S = Scalar<T>;
  T c = constant<T>(S(-0.00409941));
  for (const S next : {S(0.01764236), S(-0.04600526), S(0.16642902), S(0.86602985)})
    c = next + r * c;
  const T square = c * c, f = c * (4 * square - 3) - r, slope = 12 * square - 3;
  c -= f * slope / (slope * slope - 12 * c * f);
  return smaller(c, constant<T>(1));
}

}  // namespace spectrum

/// Eigenvalues to some eps of the matrix, the pair's distance to sqrt eps of it.
template <class T>
ELASTOGEN_HD inline Spectrum3<T> spectrum3(const Symmetric3<T>& A) {
  using S = Scalar<T>;
  constexpr S kClosest = S(sizeof(S) == 4 ? 5e-4 : 2e-8);  // of half a distance
  Spectrum3<T> s;
  // mean and deviator, which is scaled
  s.mean = (A.m[0] + A.m[1] + A.m[2]) / 3;
  Symmetric3<T>& B = s.unit = A;
  T square{};
  for (int k = 0; k < 3; ++k) {
    B.m[k] = A.m[k] - s.mean;
    square += B.m[k] * B.m[k] + 2 * B.m[3 + k] * B.m[3 + k];
  }
  s.scale = square_root(square / 6);
  const T inverse = 1 / (s.scale > 0 ? s.scale : constant<T>(1));
  for (int k = 0; k < 6; ++k) B.m[k] = B.m[k] * inverse;
  // the angle of Viete's formula
  const T det = B.m[0] * (B.m[1] * B.m[2] - B.m[4] * B.m[4]) +
                B.m[3] * (B.m[4] * B.m[5] - B.m[3] * B.m[2]) +
                B.m[5] * (B.m[3] * B.m[4] - B.m[5] * B.m[1]);
  const T c = spectrum::cosine_of_third(smaller(T(absolute(det) / 2), constant<T>(1)));
  const T half = larger(square_root(3 - 3 * c * c), constant<T>(kClosest));
  const T middle = det < 0 ? c : -c;
  // the single eigenvalue, and the pair at a distance that is never 0
  s.t[0] = -2 * middle;
  s.t[1] = middle + half;
  s.t[2] = middle - half;
  return s;
}

template <class T>
ELASTOGEN_HD inline Symmetric3<T> Spectrum3<T>::isotropic(const T f[3]) const {
  // f_3 + a (B - t_3 I) + b (B - t_3 I)(B - t_2 I), in powers of B
  const T a = (f[1] - f[2]) / (t[1] - t[2]), apart = t[0] - t[1];
  const T b = (f[0] - f[1] - a * apart) / (apart * (t[0] - t[2]));
  const T of_unit = a - b * (t[1] + t[2]), of_identity = f[2] - t[2] * (a - b * t[1]);
  const T* u = unit.m;
  const T square[6] = {
      u[0] * u[0] + u[3] * u[3] + u[5] * u[5], u[3] * u[3] + u[1] * u[1] + u[4] * u[4],
      u[5] * u[5] + u[4] * u[4] + u[2] * u[2], u[3] * (u[0] + u[1]) + u[5] * u[4],
      u[4] * (u[1] + u[2]) + u[3] * u[5],      u[5] * (u[2] + u[0]) + u[4] * u[3]};
  Symmetric3<T> result;
  for (int k = 0; k < 6; ++k)
    result.m[k] = of_unit * u[k] + b * square[k] + (k < 3 ? of_identity : T{});
  return result;
}

}  // namespace elastogen
