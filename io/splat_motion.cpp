// SPDX-License-Identifier: Apache-2.0
#include "io/splat_motion.hpp"

#include "core/eigen3.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/quaternion.hpp"
#include "core/svd3.hpp"
#include "io/splat_ply.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

constexpr int kMaxHarmonics = 16;  // harmonics of degrees 0 ... 3
constexpr int kDirections = 32;    // directions in which colours are compared; twice the unknowns
constexpr double kMaxStretch = 3;

/// Directions spread evenly over the sphere (Fibonacci lattice).
Vec3 fixed_direction(int k) {
  const double z = 1 - (2 * k + 1.0) / kDirections, r = std::sqrt(1 - z * z);
  const double angle = k * std::numbers::pi * (3 - std::sqrt(5.0));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// The row-major matrix that maps values in the fixed directions to coefficients.
std::vector<double> fit_matrix(int degree) {
  const int count = harmonic_count(degree);
  Eigen::MatrixXd values(kDirections, count);
  double row[kMaxHarmonics];
  for (int k = 0; k < kDirections; ++k) {
    spherical_harmonics(degree, fixed_direction(k), row);
    for (int m = 0; m < count; ++m) values(k, m) = row[m];
  }
  const Eigen::MatrixXd fit =
      (values.transpose() * values).ldlt().solve(Eigen::MatrixXd(values.transpose()));
  std::vector<double> result;
  for (int m = 0; m < count; ++m)
    for (int k = 0; k < kDirections; ++k) result.push_back(fit(m, k));
  return result;
}

/// The quaternion of a rotation, with the sign nearer to another quaternion.
std::array<float, 4> quaternion(const Mat3<double>& R, const std::array<float, 4>& before) {
  const Quaternion<double> found = quaternion_of(R);
  const double q[4] = {found.w, found.x, found.y, found.z};
  double along = 0;
  for (size_t c = 0; c < 4; ++c) along += q[c] * before[c];
  const double sign = along < 0 ? -1 : 1;
  return {float(sign * q[0]), float(sign * q[1]), float(sign * q[2]), float(sign * q[3])};
}

/// Removes couplings below rounding, which would turn equal axes by an arbitrary angle.
Eigen3<double> principal_axes(Symmetric3<double> S) {
  for (int p = 0; p < 3; ++p) {
    const double larger = std::max(S.m[p], S.m[(p + 1) % 3]);
    if (std::abs(S.m[3 + p]) < 1e-10 * larger) S.m[3 + p] = 0;
  }
  return eigen3(S);
}

}  // namespace

Mat3<double> rotation_matrix(const std::array<float, 4>& q) {
  double norm = 0;
  for (const float c : q) norm += double(c) * c;
  norm = 1 / std::sqrt(norm);
  const double w = q[0] * norm, x = q[1] * norm, y = q[2] * norm, z = q[3] * norm;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

void spherical_harmonics(int degree, const Vec3& direction, double* values) {
  const auto [x, y, z] = direction;
  const double xx = x * x, yy = y * y, zz = z * z;
  values[0] = kHarmonic0;
  if (degree < 1) return;
  values[1] = -0.4886025119029199 * y;
  values[2] = 0.4886025119029199 * z;
  values[3] = -0.4886025119029199 * x;
  if (degree < 2) return;
  values[4] = 1.0925484305920792 * x * y;
  values[5] = -1.0925484305920792 * y * z;
  values[6] = 0.31539156525252005 * (2 * zz - xx - yy);
  values[7] = -1.0925484305920792 * x * z;
  values[8] = 0.5462742152960396 * (xx - yy);
  if (degree < 3) return;
  values[9] = -0.5900435899266435 * y * (3 * xx - yy);
  values[10] = 2.890611442640554 * x * y * z;
  values[11] = -0.4570457994644658 * y * (4 * zz - xx - yy);
  values[12] = 0.3731763325901154 * z * (2 * zz - 3 * xx - 3 * yy);
  values[13] = -0.4570457994644658 * x * (4 * zz - xx - yy);
  values[14] = 1.445305721320277 * z * (xx - yy);
  values[15] = -0.5900435899266435 * x * (xx - 3 * yy);
}

SplatMotion::SplatMotion(const SplatCloud& splats) : rest_(splats) {
  const size_t count = splats.position.size();
  ELASTOGEN_CHECK(splats.degree >= 0 && splats.degree <= 3,
                  "the degree of the harmonics must be 0 ... 3, got ", splats.degree);
  ELASTOGEN_CHECK(splats.scale.size() == count && splats.rotation.size() == count &&
                      splats.harmonics.size() == count * size_t(harmonic_count(splats.degree)) * 3,
                  "scales, rotations and harmonics must be as many as the ", count, " splats");
  scale = splats.scale;
  rotation = splats.rotation;
  harmonics = splats.harmonics;
  fit_ = fit_matrix(splats.degree);
  for (const auto& q : splats.rotation) axes_.push_back(rotation_matrix(q));
}

void SplatMotion::turn(In<double> gradient) {
  const int64_t count = int64_t(rest_.position.size());
  ELASTOGEN_CHECK(gradient.is(count, 9), "gradient must be (", count, ", 9), got ", gradient);
  std::vector<uint8_t> is_clamped(rest_.position.size());
  for_each(count, [&](int64_t i) {
    Mat3<double> F;
    std::copy(gradient.row(i), gradient.row(i) + 9, F.m);
    is_clamped[size_t(i)] = turn_splat(size_t(i), F);
  });
  clamped = std::count(is_clamped.begin(), is_clamped.end(), 1);
}

/// Moves one splat; returns whether stretches were clamped.
bool SplatMotion::turn_splat(size_t i, const Mat3<double>& F) {
  const Mat3<double> I = identity<double>();
  const size_t floats = 3 * size_t(harmonic_count(rest_.degree));
  if (std::equal(F.m, F.m + 9, I.m)) {
    scale[i] = rest_.scale[i];
    rotation[i] = rest_.rotation[i];
    axes_[i] = rotation_matrix(rest_.rotation[i]);
    std::copy_n(rest_.harmonics.begin() + int64_t(i * floats), floats,
                harmonics.begin() + int64_t(i * floats));
    return false;
  }
  const Svd3<double> svd = svd3(F);
  const Mat3<double> R = times_transposed(svd.U, svd.V);
  Mat3<double> stretched = svd.U;
  bool is_clamped = false;
  for (int k = 0; k < 3; ++k) {
    const double s = std::clamp(svd.sigma[k], 1 / kMaxStretch, kMaxStretch);
    is_clamped = is_clamped || s != svd.sigma[k];
    for (int d = 0; d < 3; ++d) stretched(d, k) *= s;
  }

  // S' = A A^T, in the axes of the frame before, rotated by R
  Mat3<double> A = times_transposed(stretched, svd.V) * rotation_matrix(rest_.rotation[i]);
  for (int d = 0; d < 3; ++d)
    for (int k = 0; k < 3; ++k) A(d, k) *= rest_.scale[i][size_t(k)];
  const Mat3<double> guess = R * axes_[i], B = transposed_times(guess, A);
  const Mat3<double> S = times_transposed(B, B);
  const Eigen3<double> eigen =
      principal_axes({S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(1, 2), S(2, 0)});
  const auto& rest_scale = rest_.scale[i];
  const double least = *std::min_element(rest_scale.begin(), rest_scale.end()) / kMaxStretch;
  for (size_t k = 0; k < 3; ++k)
    scale[i][k] = float(std::max(std::sqrt(std::max(eigen.value[k], 0.0)), least));
  const Mat3<double> axes = guess * eigen.Q;
  rotation[i] = quaternion(axes, rotation[i]);
  axes_[i] = transposed_times(R, axes);
  if (rest_.degree > 0) turn_colour(i, R);
  return is_clamped;
}

/// Coefficients of colour(R^T v), fitted to its values in the fixed directions, exactly.
void SplatMotion::turn_colour(size_t i, const Mat3<double>& R) {
  const auto count = size_t(harmonic_count(rest_.degree));
  const float* before = rest_.harmonics.data() + i * count * 3;
  double colour[kDirections][3] = {}, values[kMaxHarmonics];
  for (int k = 0; k < kDirections; ++k) {
    const Vec3 v = fixed_direction(k);
    Vec3 turned = {};
    for (int d = 0; d < 3; ++d)
      turned[size_t(d)] = R(0, d) * v[0] + R(1, d) * v[1] + R(2, d) * v[2];
    spherical_harmonics(rest_.degree, turned, values);
    for (size_t m = 1; m < count; ++m)
      for (size_t c = 0; c < 3; ++c) colour[k][c] += values[m] * before[3 * m + c];
  }
  for (size_t m = 1; m < count; ++m)
    for (size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (int k = 0; k < kDirections; ++k) sum += fit_[m * kDirections + size_t(k)] * colour[k][c];
      harmonics[(i * count + m) * 3 + c] = float(sum);
    }
}

}  // namespace elastogen
