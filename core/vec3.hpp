// SPDX-License-Identifier: Apache-2.0
// The few operations on Vec3 that geometry needs.

#pragma once

#include "core/base.hpp"

#include <cmath>

namespace elastogen {

ELASTOGEN_HD inline Vec3 plus(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
ELASTOGEN_HD inline Vec3 minus(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
ELASTOGEN_HD inline Vec3 scaled(const Vec3& a, double s) {
  return {a[0] * s, a[1] * s, a[2] * s};
}
ELASTOGEN_HD inline double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
/// |a|, also where the squares of its components leave the range of numbers.
ELASTOGEN_HD inline double safe_norm(const Vec3& a) {
#ifdef __CUDA_ARCH__
  return norm3d(a[0], a[1], a[2]);
#else
  return std::hypot(a[0], a[1], a[2]);
#endif
}
inline double norm(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
ELASTOGEN_HD inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline bool finite(const Vec3& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

}  // namespace elastogen
