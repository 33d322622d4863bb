// SPDX-License-Identifier: Apache-2.0
// The torque-free motion of a rigid body against what it conserves, a closed form and differences.
#include "core/rigid_motion.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

/// A body of three different moments of inertia in axes of its own, turned.
struct Body {
  Mat3<double> inertia;
  RigidMotion motion;

  Body(const Vec3& moments, const Vec3& w) {
    const Quaternion<double> q = {0.5, 0.5, 0.1, 0.7};
    const double size = std::sqrt(0.25 + 0.25 + 0.01 + 0.49);
    const Mat3<double> A =
        rotation_matrix(Quaternion<double>{q.w / size, q.x / size, q.y / size, q.z / size});
    Mat3<double> D{};
    for (int i = 0; i < 3; ++i) D(i, i) = moments[size_t(i)];
    inertia = times_transposed(A * D, A);
    motion = {{1, 2, 3}, {0.5, -0.1, 0.2}, times(inertia, times(A, w)), inverse(inertia)};
  }
  /// Angular momentum and energy of the turn at a pose.
  std::pair<Vec3, double> conserved(const RigidPose& p) const {
    Mat3<double> R = p.turn;
    for (int i = 0; i < 3; ++i) R(i, i) += 1;
    const Vec3 L = times(times_transposed(R * inertia, R), p.w);
    return {L, dot(L, p.w) / 2};
  }
};

TEST(RigidMotion, KeepsMomentumEnergyAndShape) {
  const Body body({1, 2, 3.5}, {0.3, 4, 0.2});
  const double energy = body.conserved(pose_at(body.motion, 0)).second;
  for (const double t : {-0.7, 0.1, 2.0}) {
    const RigidPose p = pose_at(body.motion, t);
    const auto [L, E] = body.conserved(p);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(L[i], body.motion.spin[i], 2e-6) << t;
    EXPECT_NEAR(E, energy, 1e-6 * energy) << t;
    const Vec3 x0 = {1.4, 1.1, 3.9};
    EXPECT_NEAR(safe_norm(reference_arm(p, x0)), safe_norm(minus(x0, body.motion.centre)), 1e-14);
  }
}

TEST(RigidMotion, ASpinAboutAPrincipalAxisTurnsByItsAngle) {
  const double w = 7, t = 1.3;
  Body body({2, 2, 2}, {0, 0, w});
  body.motion.spin = {0, 0, 2 * w};
  const RigidPose p = pose_at(body.motion, t);
  const Vec3 arm = reference_arm(p, {2, 2, 3});
  EXPECT_NEAR(arm[0], std::cos(w * t), 1e-7);
  EXPECT_NEAR(arm[1], std::sin(w * t), 1e-7);
  EXPECT_NEAR(p.shift[0], 0.5 * t, 1e-15);
}

/// Checks z' and z'' of the poses at(t) against differences.
template <class Poses>
void expect_derivatives(const Poses& at, double tolerance) {
  const Vec3 x0 = {1.4, 1.1, 3.9};
  const double t = 0.2, e = 1e-4;
  const RigidPose before = at(t - e), after = at(t + e), now = at(t);
  const Vec3 v = reference_velocity(now, x0), a = reference_acceleration(now, x0);
  const Vec3 moved = minus(reference_motion(after, x0), reference_motion(before, x0));
  const Vec3 changed = minus(reference_velocity(after, x0), reference_velocity(before, x0));
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(moved[i] / (2 * e), v[i], tolerance * safe_norm(v));
    EXPECT_NEAR(changed[i] / (2 * e), a[i], tolerance * safe_norm(a));
  }
}

TEST(RigidMotion, VelocityAndAccelerationAreItsDerivatives) {
  const Body body({1, 2, 3.5}, {0.3, 4, 0.2});
  expect_derivatives([&](double t) { return pose_at(body.motion, t); }, 1e-5);
}

TEST(RigidMotion, ATurnAboutAPointHasItsDerivatives) {
  const Vec3 centre = {1, 2, 3}, w = {0.3, -4, 1}, x0 = {1.4, 1.1, 3.9};
  const double gain = 2.5;
  expect_derivatives([&](double t) { return turned_about(centre, w, gain, t); }, 1e-6);
  EXPECT_EQ(reference_motion(turned_about(centre, w, gain, 0.2), centre), (Vec3{}));
  EXPECT_EQ(reference_motion(turned_about(centre, {}, gain, 0.2), x0), (Vec3{}));
}

TEST(RigidMotion, WhatIsHeldStays) {
  const RigidPose p = pose_at(RigidMotion{}, 0.5);
  EXPECT_EQ(reference_motion(p, {1, 2, 3}), (Vec3{}));
  EXPECT_EQ(reference_velocity(p, {1, 2, 3}), (Vec3{}));
}

// a body that has come to rest may turn by the smallest numbers there are
TEST(RigidMotion, ATurnTooSlowForItsInverseIsNone) {
  const Vec3 x0 = {1, 2, 3};
  const RigidPose p = turned_about({}, {0, 4.9e-324, 0}, 0, 0.1);
  EXPECT_EQ(reference_motion(p, x0), (Vec3{}));
  EXPECT_EQ(reference_velocity(p, x0), (Vec3{}));
  EXPECT_EQ(reference_acceleration(p, x0), (Vec3{}));
}

}  // namespace
}  // namespace elastogen
