// SPDX-License-Identifier: Apache-2.0
// Random 3x3 matrices: rotations, given stretches, and the families on which the algebra is tested.

#pragma once

#include "core/mat3.hpp"

#include <cmath>
#include <random>

namespace elastogen::test {

using Random = std::mt19937_64;

inline Mat3<double> gaussian(Random& random) {
  std::normal_distribution<double> normal;
  Mat3<double> A;
  for (double& a : A.m) a = normal(random);
  return A;
}

/// The rotation of a quaternion of any length but 0.
inline Mat3<double> rotation_of(double w, double x, double y, double z) {
  const double s = 2 / (w * w + x * x + y * y + z * z);
  return {{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),  //
           s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x),  //
           s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}};
}

inline Mat3<double> rotation(Random& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
  return rotation_of(w, x, y, z);
}

/// The rotation by an angle about a random axis.
inline Mat3<double> rotation_by(double angle, Random& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  const double scale = std::sin(angle / 2) / std::sqrt(x * x + y * y + z * z);
  return rotation_of(std::cos(angle / 2), x * scale, y * scale, z * scale);
}

/// R diag(a, b, c) Q with random rotations R and Q.
inline Mat3<double> stretched(double a, double b, double c, Random& random) {
  const double s[3] = {a, b, c};
  Mat3<double> R = rotation(random);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R(i, j) *= s[j];
  return R * rotation(random);
}

/// Stretches uniform in [lower, upper].
inline Mat3<double> stretched_within(double lower, double upper, Random& random) {
  std::uniform_real_distribution<double> in(lower, upper);
  const double a = in(random), b = in(random), c = in(random);
  return stretched(a, b, c, random);
}

inline Mat3<double> scaled(Mat3<double> A, double factor) {
  for (double& a : A.m) a *= factor;
  return A;
}

inline double power_of_ten(double lower, double upper, Random& random) {
  return std::pow(10.0, std::uniform_real_distribution<double>(lower, upper)(random));
}

struct Family {
  const char* name;
  Mat3<double> (*draw)(Random&);
};

inline const Family kFamilies[10] = {
    {"gaussian", gaussian},
    {"scaled by 1e-20 to 1e20",
     [](Random& r) { return scaled(gaussian(r), power_of_ten(-20, 20, r)); }},
    {"stretches 2, 2, 1", [](Random& r) { return stretched(2, 2, 1, r); }},
    {"1.7 times a rotation", [](Random& r) { return stretched(1.7, 1.7, 1.7, r); }},
    {"rank 2", [](Random& r) { return stretched(1.5, 0.5, 0, r); }},
    {"rank 1", [](Random& r) { return stretched(1.5, 0, 0, r); }},
    {"zero", [](Random&) { return Mat3<double>{}; }},
    {"condition up to 1e15",
     [](Random& r) { return stretched(1, power_of_ten(-15, 0, r), power_of_ten(-15, 0, r), r); }},
    {"identity and noise of 1e-7",
     [](Random& r) {
       Mat3<double> A = scaled(gaussian(r), 1e-7);
       for (int i = 0; i < 3; ++i) A(i, i) += 1;
       return A;
     }},
    {"reflected",
     [](Random& r) {
       Mat3<double> A = gaussian(r);
       const double sign = determinant(A) > 0 ? -1 : 1;
       for (int j = 0; j < 3; ++j) A(0, j) *= sign;
       return A;
     }},
};

template <class To, class From>
Mat3<To> cast(const Mat3<From>& A) {
  Mat3<To> B;
  for (int k = 0; k < 9; ++k) B.m[k] = To(A.m[k]);
  return B;
}

/// Eight matrices as one of packs, and one of them back.
template <class S>
Mat3<Pack<S>> packed(const Mat3<S> A[kLanes]) {
  Mat3<Pack<S>> B;
  for (int k = 0; k < 9; ++k)
    for (int lane = 0; lane < kLanes; ++lane) B.m[k][lane] = A[lane].m[k];
  return B;
}

template <class S>
Mat3<S> lane_of(const Mat3<Pack<S>>& A, int lane) {
  Mat3<S> B;
  for (int k = 0; k < 9; ++k) B.m[k] = A.m[k][lane];
  return B;
}

/// Frobenius norm, and that of A - B.
template <class S>
S norm(const Mat3<S>& A) {
  S sum = 0;
  for (const S a : A.m) sum += a * a;
  return std::sqrt(sum);
}

template <class S>
S distance(const Mat3<S>& A, const Mat3<S>& B) {
  S sum = 0;
  for (int k = 0; k < 9; ++k) sum += (A.m[k] - B.m[k]) * (A.m[k] - B.m[k]);
  return std::sqrt(sum);
}

}  // namespace elastogen::test
