// SPDX-License-Identifier: Apache-2.0
// Rotations as unit quaternions: four numbers, read by one load.

#pragma once

#include "core/mat3.hpp"

namespace elastogen {

template <class T>
struct alignas(4 * sizeof(T)) Quaternion {
  T w, x, y, z;
};

/// Unit quaternion of a rotation (Shepperd 1978), to the rounding of T; its largest component is
/// positive.
template <class T>
ELASTOGEN_HD inline Quaternion<T> quaternion_of(const Mat3<T>& R) {
  // four times the squares of the components; the largest divides
  const T w = 1 + R(0, 0) + R(1, 1) + R(2, 2), x = 1 + R(0, 0) - R(1, 1) - R(2, 2),
          y = 1 - R(0, 0) + R(1, 1) - R(2, 2), z = 1 - R(0, 0) - R(1, 1) + R(2, 2);
  const T wx = R(2, 1) - R(1, 2), wy = R(0, 2) - R(2, 0), wz = R(1, 0) - R(0, 1);
  const T xy = R(0, 1) + R(1, 0), yz = R(1, 2) + R(2, 1), zx = R(2, 0) + R(0, 2);
  Quaternion<T> q = {w, wx, wy, wz};
  T most = w;
  if (x > most) q = {wx, x, xy, zx}, most = x;
  if (y > most) q = {wy, xy, y, yz}, most = y;
  if (z > most) q = {wz, zx, yz, z};
  const T scale = 1 / square_root(T(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z));
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

/// The rotation of a unit quaternion.
template <class T>
ELASTOGEN_HD inline Mat3<T> rotation_matrix(const Quaternion<T>& q) {
  return {
      {1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.w * q.z), 2 * (q.x * q.z + q.w * q.y),
       2 * (q.x * q.y + q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.w * q.x),
       2 * (q.x * q.z - q.w * q.y), 2 * (q.y * q.z + q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)}};
}

/// rotation_matrix, but 0 for the quaternion 0.
template <class T>
ELASTOGEN_HD inline Mat3<T> rotation_or_zero(const Quaternion<T>& q) {
  Mat3<T> R = rotation_matrix(q);
  const T square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  for (int i = 0; i < 3; ++i) R(i, i) += square - 1;
  return R;
}

}  // namespace elastogen
