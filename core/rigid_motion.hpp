// SPDX-License-Identifier: Apache-2.0
// The rigid motion that a piece would make from the start of a step on if no force and no torque
// acted on it (Newton and Euler):
//
//     z(t) = c0 + V0 t + R(t) r0,     r0 = x0 - c0,
//     R' = [w] R,     w = R I0^-1 R^T L0,     w' = -R I0^-1 R^T (w x L0).
//
// Time schemes act on the motion relative to z (time_stage.hpp), so that a spin costs them no error.
// Shared by host and device.

#pragma once

#include "core/mat3.hpp"
#include "core/quaternion.hpp"
#include "core/vec3.hpp"

namespace elastogen {

/// A piece at the start of a step: centre of mass [m], its velocity [m/s], angular momentum about
/// it [kg m^2/s], inverse of the moments of inertia [1/(kg m^2)]. One that is held does not move.
struct RigidMotion {
  Vec3 centre = {}, velocity = {}, spin = {};
  Mat3<double> per_inertia = {};
};

/// Where that motion is at a time, with what its nodes need.
struct RigidPose {
  Vec3 start = {};             ///< c0 [m]
  Vec3 shift = {};             ///< of the centre since then [m]
  Mat3<double> turn = {};      ///< R - 1
  Vec3 velocity = {};          ///< of the centre [m/s]
  Vec3 w = {}, w_change = {};  ///< angular velocity [rad/s] and its derivative [rad/s^2]
};

ELASTOGEN_HD inline Vec3 times(const Mat3<double>& A, const Vec3& v) {
  Vec3 result = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result[size_t(i)] += A(i, j) * v[size_t(j)];
  return result;
}

/// w at the rotation R.
ELASTOGEN_HD inline Vec3 spin_rate(const RigidMotion& m, const Mat3<double>& R, const Vec3& L) {
  return times(R, times(m.per_inertia, times(transposed_times(R, identity<double>()), L)));
}

/// q' = w q / 2 with the angular velocity w at q.
ELASTOGEN_HD inline Quaternion<double> turning_rate(const RigidMotion& m,
                                                    const Quaternion<double>& q) {
  const double size = square_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const Mat3<double> R =
      rotation_matrix(Quaternion<double>{q.w / size, q.x / size, q.y / size, q.z / size});
  const Vec3 w = spin_rate(m, R, m.spin);
  return {-(w[0] * q.x + w[1] * q.y + w[2] * q.z) / 2, (w[0] * q.w + w[1] * q.z - w[2] * q.y) / 2,
          (w[1] * q.w + w[2] * q.x - w[0] * q.z) / 2, (w[2] * q.w + w[0] * q.y - w[1] * q.x) / 2};
}

/// The pose at time t, which may be below 0: Runge and Kutta's fourth order in steps of at most
/// 0.05 rad, with an error below 1e-8 rad in each.
ELASTOGEN_HD inline RigidPose pose_at(const RigidMotion& m, double t) {
  RigidPose pose;
  pose.start = m.centre;
  pose.shift = scaled(m.velocity, t);
  pose.velocity = m.velocity;

  // the rotation, and what follows from it
  Quaternion<double> q = {1, 0, 0, 0};
  const auto moved = [&](double share, const Quaternion<double>& rate) -> Quaternion<double> {
    return {q.w + share * rate.w, q.x + share * rate.x, q.y + share * rate.y, q.z + share * rate.z};
  };
  const Vec3 w0 = spin_rate(m, identity<double>(), m.spin);
  const double angle = safe_norm(w0) * (t < 0 ? -t : t);
  const int steps = 1 + int(angle < 2000 ? angle / 0.05 : 40000);
  const double part = t / steps;
  for (int k = 0; k < steps && angle > 0; ++k) {
    const Quaternion<double> a = turning_rate(m, q), b = turning_rate(m, moved(part / 2, a)),
                             c = turning_rate(m, moved(part / 2, b)),
                             d = turning_rate(m, moved(part, c));
    q = moved(part / 6, {a.w + 2 * (b.w + c.w) + d.w, a.x + 2 * (b.x + c.x) + d.x,
                         a.y + 2 * (b.y + c.y) + d.y, a.z + 2 * (b.z + c.z) + d.z});
    const double size = square_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    q = {q.w / size, q.x / size, q.y / size, q.z / size};
  }

  const Mat3<double> R = rotation_matrix(q);
  pose.turn = R;
  for (int i = 0; i < 3; ++i) pose.turn(i, i) -= 1;
  pose.w = spin_rate(m, R, m.spin);
  pose.w_change = scaled(spin_rate(m, R, cross(pose.w, m.spin)), -1);
  return pose;
}

/// Angular velocity below which a piece does not turn [rad/s]: its inverse and square are numbers.
inline constexpr double kStill = 1e-100;

/// The pose at time t of a piece that turns about a fixed point, by w t + gain t^2 / 2 about the axis
/// of w; the gain is a change of |w| [rad/s^2]. The reference of a piece with pins: any will do.
ELASTOGEN_HD inline RigidPose turned_about(const Vec3& centre, const Vec3& w, double gain,
                                           double t) {
  RigidPose pose;
  pose.start = centre;
  const double rate = safe_norm(w), angle = rate * t + gain * t * t / 2;
  if (!(rate > kStill)) return pose;
  const Vec3 axis = scaled(w, 1 / rate);
  const double s = sin(angle / 2);
  pose.turn =
      rotation_matrix(Quaternion<double>{cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]});
  for (int i = 0; i < 3; ++i) pose.turn(i, i) -= 1;
  pose.w = scaled(axis, rate + gain * t);
  pose.w_change = scaled(axis, gain);
  return pose;
}

/// z(t) - x0 of a node.
ELASTOGEN_HD inline Vec3 reference_motion(const RigidPose& p, const Vec3& x0) {
  return plus(p.shift, times(p.turn, minus(x0, p.start)));
}

/// R(t) r0 of a node.
ELASTOGEN_HD inline Vec3 reference_arm(const RigidPose& p, const Vec3& x0) {
  const Vec3 r0 = minus(x0, p.start);
  return plus(r0, times(p.turn, r0));
}

/// z'(t) of a node.
ELASTOGEN_HD inline Vec3 reference_velocity(const RigidPose& p, const Vec3& x0) {
  return plus(p.velocity, cross(p.w, reference_arm(p, x0)));
}

/// z''(t) of a node.
ELASTOGEN_HD inline Vec3 reference_acceleration(const RigidPose& p, const Vec3& x0) {
  const Vec3 r = reference_arm(p, x0);
  return plus(cross(p.w_change, r), cross(p.w, cross(p.w, r)));
}

}  // namespace elastogen
