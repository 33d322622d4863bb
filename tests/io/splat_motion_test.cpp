// SPDX-License-Identifier: Apache-2.0
#include "io/splat_motion.hpp"

#include "core/error.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace elastogen {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d, Eigen::Quaterniond;

/// Splats of any shape, the first three with equal axes.
SplatCloud random_splats(int count, int degree) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(-1, 1);
  SplatCloud splats;
  splats.degree = degree;
  for (int i = 0; i < count; ++i) {
    splats.position.push_back({unit(random), unit(random), unit(random)});
    std::array<float, 3> scale;
    for (float& s : scale) s = 0.1f * std::exp(2 * unit(random));
    if (i == 0) scale = {0.2f, 0.2f, 0.2f};
    if (i == 1) scale = {0.2f, 0.2f, 1e-4f};
    if (i == 2) scale = {1e-3f, 0.2f, 1e-3f};
    splats.scale.push_back(scale);
    Quaterniond q(unit(random), unit(random), unit(random), unit(random));
    q.normalize();
    splats.rotation.push_back({float(q.w()), float(q.x()), float(q.y()), float(q.z())});
    splats.opacity.push_back(0.5f);
    for (int k = 0; k < 3 * (degree + 1) * (degree + 1); ++k)
      splats.harmonics.push_back(unit(random));
  }
  return splats;
}

Matrix3d covariance(const std::array<float, 3>& scale, const std::array<float, 4>& q) {
  const Matrix3d R = Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  const Vector3d s(scale[0], scale[1], scale[2]);
  return R * s.cwiseAbs2().asDiagonal() * R.transpose();
}

Array<double> gradients(int64_t count, const Matrix3d& F) {
  Array<double> result(count, 9);
  for (int64_t i = 0; i < count; ++i)
    for (int k = 0; k < 9; ++k) result(i, k) = F(k / 3, k % 3);
  return result;
}

Matrix3d turn(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// Real harmonics from the standard library's associated Legendre functions.
double harmonic(int l, int m, const Vector3d& v) {
  const double theta = std::acos(std::clamp(v[2], -1.0, 1.0)), phi = std::atan2(v[1], v[0]);
  const double value = std::sph_legendre(unsigned(l), unsigned(std::abs(m)), theta);
  if (m == 0) return value;
  return std::numbers::sqrt2 * value * (m > 0 ? std::cos(m * phi) : std::sin(-m * phi));
}

double colour(const std::vector<float>& harmonics, int degree, size_t splat, size_t channel,
              const Vector3d& v) {
  double sum = 0;
  size_t k = splat * size_t((degree + 1) * (degree + 1));
  for (int l = 0; l <= degree; ++l)
    for (int m = -l; m <= l; ++m) sum += harmonics[3 * k++ + channel] * harmonic(l, m, v);
  return sum;
}

double relative_error(const Matrix3d& a, const Matrix3d& b) {
  return (a - b).norm() / b.norm();
}

TEST(SphericalHarmonics, AreThoseOfTheStandardLibrary) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 50; ++k) {
    const Vector3d v = Vector3d(normal(random), normal(random), normal(random)).normalized();
    double values[16];
    spherical_harmonics(3, {v[0], v[1], v[2]}, values);
    for (int l = 0, i = 0; l <= 3; ++l)
      for (int m = -l; m <= l; ++m, ++i) ASSERT_NEAR(values[i], harmonic(l, m, v), 1e-12);
  }
}

TEST(SplatMotion, TheIdentityKeepsTheBits) {
  const SplatCloud splats = random_splats(20, 3);
  SplatMotion motion(splats);
  motion.turn(gradients(20, turn(1, {1, 2, 3})));
  motion.turn(gradients(20, Matrix3d::Identity()));
  EXPECT_EQ(motion.scale, splats.scale);
  EXPECT_EQ(motion.rotation, splats.rotation);
  EXPECT_EQ(motion.harmonics, splats.harmonics);
  EXPECT_EQ(motion.clamped, 0);
}

TEST(SplatMotion, ARotationTurnsCovarianceAndColours) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Matrix3d R = turn(2.3, {0.3, -1, 0.5});
  for (int degree = 0; degree <= 3; ++degree) {
    const SplatCloud splats = random_splats(10, degree);
    SplatMotion motion(splats);
    motion.turn(gradients(10, R));
    EXPECT_EQ(motion.clamped, 0);
    for (size_t i = 0; i < 10; ++i) {
      const Matrix3d expected = R * covariance(splats.scale[i], splats.rotation[i]) * R.transpose();
      ASSERT_LT(relative_error(covariance(motion.scale[i], motion.rotation[i]), expected), 1e-6);
      for (int k = 0; k < 200; ++k) {
        const Vector3d v = Vector3d(normal(random), normal(random), normal(random)).normalized();
        for (size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(colour(motion.harmonics, degree, i, c, R * v),
                      colour(splats.harmonics, degree, i, c, v), 1e-5);
      }
    }
  }
}

TEST(SplatMotion, AUniformStretchScales) {
  const SplatCloud splats = random_splats(20, 1);
  SplatMotion motion(splats);
  motion.turn(gradients(20, 1.7 * Matrix3d::Identity()));
  for (size_t i = 0; i < 20; ++i)
    for (size_t k = 0; k < 3; ++k)
      ASSERT_NEAR(motion.scale[i][k] / (1.7 * splats.scale[i][k]), 1, 1e-6);
  for (size_t k = 0; k < splats.harmonics.size(); ++k)
    ASSERT_NEAR(motion.harmonics[k], splats.harmonics[k], 1e-6);
}

TEST(SplatMotion, AShearGivesThePrincipalAxesOfTheCovariance) {
  Matrix3d F = Matrix3d::Identity();
  F(0, 1) = 0.8, F(2, 0) = -0.3, F(1, 1) = 1.2;
  const SplatCloud splats = random_splats(50, 0);
  SplatMotion motion(splats);
  motion.turn(gradients(50, F));
  EXPECT_EQ(motion.clamped, 0);
  for (size_t i = 0; i < 50; ++i) {
    const Matrix3d S = F * covariance(splats.scale[i], splats.rotation[i]) * F.transpose();
    ASSERT_LT(relative_error(covariance(motion.scale[i], motion.rotation[i]), S), 1e-6);
    const Vector3d values = Eigen::SelfAdjointEigenSolver<Matrix3d>(S).eigenvalues();
    std::array<float, 3> scale = motion.scale[i];
    std::sort(scale.begin(), scale.end());
    for (int k = 1; k < 3; ++k) ASSERT_NEAR(scale[size_t(k)] / std::sqrt(values[k]), 1, 1e-6);
    ASSERT_NEAR(scale[0] / std::sqrt(values[0]), 1, 1e-4);
  }
}

TEST(SplatMotion, StretchesAreClampedAndInversionUndone) {
  const SplatCloud splats = random_splats(1, 0);  // round, 0.2
  SplatMotion motion(splats);
  motion.turn(gradients(1, Vector3d(10, 1, 0.01).asDiagonal().toDenseMatrix()));
  EXPECT_EQ(motion.clamped, 1);
  std::array<float, 3> scale = motion.scale[0];
  std::sort(scale.begin(), scale.end());
  EXPECT_NEAR(scale[0], 0.2 / 3, 1e-7);
  EXPECT_NEAR(scale[1], 0.2, 1e-7);
  EXPECT_NEAR(scale[2], 0.6, 1e-7);
  motion.turn(gradients(1, Vector3d(1, 1, -1).asDiagonal().toDenseMatrix()));
  EXPECT_EQ(motion.clamped, 1);
  motion.turn(gradients(1, Matrix3d::Zero()));
  for (const float s : motion.scale[0]) EXPECT_NEAR(s, 0.2 / 3, 1e-7);
}

TEST(SplatMotion, QuaternionsDoNotJumpFromFrameToFrame) {
  const SplatCloud splats = random_splats(30, 0);
  SplatMotion motion(splats);
  std::vector<std::array<float, 4>> before = motion.rotation;
  for (int frame = 1; frame <= 120; ++frame) {
    // two and a half turns while an axis of the body is stretched by up to a half
    const double t = frame / 120.0;
    const Matrix3d stretch = Vector3d(1 + 0.5 * t, 1, 1 - 0.2 * t).asDiagonal().toDenseMatrix();
    const double angle = 5 * std::numbers::pi * t;
    motion.turn(gradients(30, turn(angle, {1, 0.2, -0.4}) * stretch));
    const double step = 5 * std::numbers::pi / 120;
    for (size_t i = 3; i < 30; ++i) {  // axes of the first three are free
      double change = 0;
      for (size_t k = 0; k < 4; ++k) change += std::pow(motion.rotation[i][k] - before[i][k], 2);
      // the turn alone moves a quaternion by 2 sin(step/4); the axes turn in the body as well
      ASSERT_LT(std::sqrt(change), 2 * std::sin(step / 4) + 0.1) << i << ' ' << frame;
    }
    before = motion.rotation;
  }
}

TEST(SplatMotion, ARigidTurnMovesEqualAxesWithTheBody) {
  const SplatCloud splats = random_splats(3, 0);
  SplatMotion motion(splats);
  for (int frame = 1; frame <= 120; ++frame) {
    const Matrix3d R = turn(5 * std::numbers::pi * frame / 120.0, {1, 0.2, -0.4});
    motion.turn(gradients(3, R));
    for (size_t i = 0; i < 3; ++i) {
      const auto &q = motion.rotation[i], &r = splats.rotation[i];
      const Matrix3d expected = R * Quaterniond(r[0], r[1], r[2], r[3]).toRotationMatrix();
      ASSERT_LT((Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix() - expected).norm(), 1e-5);
    }
  }
}

TEST(SplatMotion, RefusesWhatDoesNotFit) {
  SplatCloud splats = random_splats(2, 1);
  SplatMotion motion(splats);
  EXPECT_THROW(motion.turn(gradients(3, Matrix3d::Identity())), Error);
  SplatCloud bad = splats;
  bad.degree = 4;
  EXPECT_THROW(SplatMotion{bad}, Error);
  bad = splats;
  bad.harmonics.pop_back();
  EXPECT_THROW(SplatMotion{bad}, Error);
  const SplatCloud empty;  // the motion refers to it
  SplatMotion none(empty);
  none.turn(Array<double>(0, 9));
  EXPECT_EQ(none.clamped, 0);
}

}  // namespace
}  // namespace elastogen
