// SPDX-License-Identifier: Apache-2.0
// What stages add up over the nodes of each piece: a node adds to kPieceSums numbers. Arrays are
// (nodes, 3), in the memory of the machine. Shared by host and device.

#pragma once

#include "network/step/stage_nodes.hpp"

#include <variant>

namespace elastogen {

inline constexpr int kPieceSums = 9;
using PieceSums = std::array<double, kPieceSums>;

/// m r and m v, r from the first node of the piece, so that no digits are lost far from the origin;
/// then the place of that node. v may be null: at rest.
struct FirstMoments {
  StageNodes of;
  const double *x, *v;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const int64_t first = of.first[of.piece[n]];
    const Vec3 r = minus(vector_at(x, n), vector_at(x, first));
    for (size_t i = 0; i < 3; ++i) {
      sum[i] += of.mass[n] * r[i];
      if (v != nullptr) sum[3 + i] += of.mass[n] * v[3 * n + int64_t(i)];
      if (n == first) sum[6 + i] += x[3 * n + int64_t(i)];
    }
  }
};

/// Spin about the centre of mass, m r_i^2 and m r_i r_j, r from that.
struct SecondMoments {
  StageNodes of;
  const PieceMotion* about;
  const double *x, *v;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const PieceMotion& whole = about[of.piece[n]];
    const Vec3 r = minus(vector_at(x, n), whole.centre);
    const Vec3 L = cross(r, minus(v != nullptr ? vector_at(v, n) : Vec3{}, whole.velocity));
    for (size_t i = 0; i < 3; ++i) {
      sum[i] += of.mass[n] * L[i];
      sum[3 + i] += of.mass[n] * r[i] * r[i];
      sum[6 + i] += of.mass[n] * r[i] * r[(i + 1) % 3];
    }
  }
};

/// m a.a, m a.b and m b.b.
struct Products {
  StageNodes of;
  const double *a, *b;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const Vec3 p = vector_at(a, n), q = vector_at(b, n);
    sum[0] += of.mass[n] * dot(p, p);
    sum[1] += of.mass[n] * dot(p, q);
    sum[2] += of.mass[n] * dot(q, q);
  }
};

/// Kinetic energy and that of gravity.
struct MotionEnergies {
  StageNodes of;
  const double *x, *v;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const Vec3 speed = vector_at(v, n);
    sum[0] += of.mass[n] * (dot(speed, speed) / 2 - dot(of.gravity, vector_at(x, n)));
  }
};

/// m v, r x m v, kinetic energy and that of gravity, of pinned nodes that alone; r from a fixed point.
struct WholeMotion {
  StageNodes of;
  Vec3 about;
  const double *x, *v;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const Vec3 place = vector_at(x, n), speed = vector_at(v, n);
    sum[7] -= of.mass[n] * dot(of.gravity, place);
    if (of.pinned[n] == kPinnedNode) return;
    const Vec3 P = scaled(speed, of.mass[n]), L = cross(minus(place, about), P);
    for (size_t i = 0; i < 3; ++i) sum[i] += P[i], sum[3 + i] += L[i];
    sum[6] += dot(P, speed) / 2;
  }
};

/// At a stage f = m a - r and arm x f, a the acceleration of free nodes, r the gradient of Phi and arm
/// from a fixed point; then r.v and kinetic energy, v the velocities that the scheme gives.
struct StageForces {
  StageNodes of;
  Vec3 about;
  const double *gradient, *x;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    if (of.pinned[n] == kPinnedNode) return;
    const Vec3 place = vector_at(x, n), v = of.velocity(n, place), r = vector_at(gradient, n);
    const Vec3 away = minus(minus(place, of.x0(n)), of.predicted(n));
    const Vec3 a = plus(of.pull(n), scaled(away, 1 / (of.stage.k * of.stage.k)));
    const Vec3 f = minus(scaled(a, of.mass[n]), r), torque = cross(minus(place, about), f);
    for (size_t i = 0; i < 3; ++i) sum[i] += f[i], sum[3 + i] += torque[i];
    sum[6] += dot(r, v);
    sum[7] += of.mass[n] * dot(v, v) / 2;
  }
};

/// Loads, their torques about a point, and their power at a stage; pinned nodes have moved evenly.
struct LoadForces {
  StageNodes of;
  Vec3 about;
  const double* x;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const Vec3 force = vector_at(of.load, n), place = vector_at(x, n),
               torque = cross(minus(place, about), force);
    const Vec3 v = of.pinned[n] == kPinnedNode ? scaled(minus(place, of.x0(n)), 1 / of.stage.t)
                                               : of.velocity(n, place);
    for (size_t i = 0; i < 3; ++i) sum[i] += force[i], sum[3 + i] += torque[i];
    sum[6] += dot(force, v);
  }
};

/// What the momentum and the angular momentum of the reference of nodes of pinned pieces gain in a step
/// beyond their integral by its stages.
struct ReferenceGain {
  StageNodes of;
  Vec3 about;

  /// Adds weight m times a vector of the reference and its moment.
  ELASTOGEN_HD void add(int64_t n, const RigidPose& pose, double weight, const Vec3& of_reference,
                        double* sum) const {
    const Vec3 place = plus(of.x0(n), of.reference_way(pose, n));
    const Vec3 value = scaled(of_reference, weight * of.mass[n]);
    const Vec3 moment = cross(minus(place, about), value);
    for (size_t i = 0; i < 3; ++i) sum[i] += value[i], sum[3 + i] += moment[i];
  }
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const PiecePoses& at = of.poses_of(n);
    if (of.pinned[n] == kPinnedNode || at.is_loose) return;
    const TimeStage& s = of.stage;
    add(n, at.end, 1, of.reference_speed(at.end, n), sum);
    add(n, at.end, -s.k, of.reference_pull(at.end, n), sum);
    add(n, at.start, s.t_b < 0 ? s.w_d - 1 : -1, of.reference_speed(at.start, n), sum);
    if (s.t_b < 0) add(n, at.other, -s.w_d, of.reference_speed(at.other, n), sum);
    if (s.t_b > 0) add(n, at.other, s.k - s.t, of.reference_pull(at.other, n), sum);
  }
};

using NodeSum = std::variant<FirstMoments, SecondMoments, Products, MotionEnergies, WholeMotion,
                             StageForces, LoadForces, ReferenceGain>;

}  // namespace elastogen
