// SPDX-License-Identifier: Apache-2.0
// The formulas of a stage at a node (core/time_stage.hpp), whose motion is relative to the rigid
// reference of its piece. Shared by host and device; stage_passes.hpp has the loops.

#pragma once

#include "core/dependent_nodes.hpp"
#include "core/rigid_motion.hpp"
#include "core/time_stage.hpp"

namespace elastogen {

ELASTOGEN_HD inline Vec3 vector_at(const double* of, int64_t n) {
  return {of[3 * n], of[3 * n + 1], of[3 * n + 2]};
}
ELASTOGEN_HD inline void set_vector(double* of, int64_t n, const Vec3& value) {
  for (size_t d = 0; d < 3; ++d) of[3 * n + int64_t(d)] = value[d];
}

/// The reference of a piece at the start of the step, at the other point and at the stage.
struct PiecePoses {
  RigidPose start, other, end;
  bool is_loose = false;  ///< no node of the piece is pinned or depends on others
};

/// A rigid motion of a piece: of its centre, and about it.
struct PieceMotion {
  Vec3 centre = {}, velocity = {}, turn = {};  ///< [m], [m/s], [rad/s]

  ELASTOGEN_HD Vec3 at(const Vec3& place) const {
    return plus(velocity, cross(turn, minus(place, centre)));
  }
};

/// The state at the start of a step, (nodes, 3); that before it is read where t_b < 0.
struct StateArrays {
  const double *x = nullptr, *v = nullptr;                ///< [m], [m/s]
  const double *x_before = nullptr, *v_before = nullptr;  ///< of the step before
};

/// The nodes of a body in a stage.
struct StageNodes {
  // the scene, in the memory of the machine
  const double *rest = nullptr, *mass = nullptr;     ///< [m], (nodes, 3); [kg], (nodes)
  const uint8_t* pinned = nullptr;                   ///< NodeKind, as Pieces::kinds(), (nodes)
  const int32_t *piece = nullptr, *first = nullptr;  ///< of each node; first node of each piece
  const double* first_stage = nullptr;               ///< x at the end of SDIRK2's first stage [m]
  WeightedSums parents;                              ///< of dependent nodes
  const double* load = nullptr;                      ///< [N], (nodes, 3); null: none
  Vec3 gravity = {};
  // the step; filled by Stages::begin
  StateArrays state = {};
  const PiecePoses* poses = nullptr;  ///< (pieces)
  TimeStage stage = {};

  ELASTOGEN_HD const PiecePoses& poses_of(int64_t n) const { return poses[piece[n]]; }
  ELASTOGEN_HD Vec3 x0(int64_t n) const { return vector_at(state.x, n); }
  /// Acceleration by gravity and load.
  ELASTOGEN_HD Vec3 pull(int64_t n) const {
    return load == nullptr ? gravity : plus(gravity, scaled(vector_at(load, n), 1 / mass[n]));
  }

  /// A vector of the reference, by the function `of` of places at the start; that of dependent nodes
  /// follows from their parent nodes, so that the reference meets what holds them.
  template <class Of>
  ELASTOGEN_HD Vec3 of_reference(int64_t n, const Of& of) const {
    if (pinned[n] != kDependentNode) return of(x0(n));
    int64_t i = 0;  // the last one up to n
    for (int64_t end = parents.count; end - i > 1;) {
      const int64_t middle = (i + end) / 2;
      (parents.nodes[middle] <= n ? i : end) = middle;
    }
    Vec3 sum = {};
    for (int32_t m = parents.begin[i]; m < parents.begin[i + 1]; ++m)
      sum = plus(sum, scaled(of(x0(parents.sources[m])), parents.weights[m]));
    return sum;
  }
  /// z - x0, z' and z''.
  ELASTOGEN_HD Vec3 reference_way(const RigidPose& pose, int64_t n) const {
    return of_reference(n, [&](const Vec3& x) { return reference_motion(pose, x); });
  }
  ELASTOGEN_HD Vec3 reference_speed(const RigidPose& pose, int64_t n) const {
    return of_reference(n, [&](const Vec3& x) { return reference_velocity(pose, x); });
  }
  ELASTOGEN_HD Vec3 reference_pull(const RigidPose& pose, int64_t n) const {
    return of_reference(n, [&](const Vec3& x) { return reference_acceleration(pose, x); });
  }

  /// e at the start of the step.
  ELASTOGEN_HD Vec3 e0(int64_t n) const {
    return minus(vector_at(state.v, n), reference_speed(poses_of(n).start, n));
  }
  /// d and e at the other point.
  ELASTOGEN_HD Vec3 d_b(int64_t n) const {
    const Vec3 x = vector_at(stage.t_b > 0 ? first_stage : state.x_before, n);
    return minus(minus(x, x0(n)), reference_way(poses_of(n).other, n));
  }
  ELASTOGEN_HD Vec3 e_b(int64_t n) const {
    if (stage.t_b > 0) return scaled(d_b(n), 1 / stage.t_b);  // k of the first stage
    return minus(vector_at(state.v_before, n), reference_speed(poses_of(n).other, n));
  }
  /// e at the stage, of velocities v.
  ELASTOGEN_HD Vec3 e1(int64_t n, const double* v) const {
    return minus(vector_at(v, n), reference_speed(poses_of(n).end, n));
  }

  /// xhat - x0.
  ELASTOGEN_HD Vec3 predicted(int64_t n) const {
    const RigidPose& pose = poses_of(n).end;
    Vec3 motion = plus(reference_way(pose, n), scaled(e0(n), stage.w_0));
    const Vec3 relative = minus(pull(n), reference_pull(pose, n));
    motion = plus(motion, scaled(relative, stage.k * stage.k));
    if (stage.w_d != 0) motion = plus(motion, scaled(d_b(n), stage.w_d));
    if (stage.w_e != 0) motion = plus(motion, scaled(e_b(n), stage.w_e));
    return motion;
  }

  /// x - x0 where e stays constant (order 1), or where d is a parabola through the other point.
  ELASTOGEN_HD Vec3 extrapolated(int64_t n, int order) const {
    const double t = stage.t, t_b = stage.t_b;
    const Vec3 e = e0(n);
    const Vec3 motion = plus(reference_way(poses_of(n).end, n), scaled(e, t));
    if (order < 2) return motion;
    const Vec3 bend = t_b > 0 ? scaled(minus(d_b(n), scaled(e, t_b)), 1 / (t_b * t_b))
                              : scaled(minus(e, e_b(n)), -0.5 / t_b);
    return plus(motion, scaled(bend, t * t));
  }

  /// v at the end of the stage, at a place x.
  ELASTOGEN_HD Vec3 velocity(int64_t n, const Vec3& x) const {
    const RigidPose& pose = poses_of(n).end;
    Vec3 d = minus(minus(x, x0(n)), reference_way(pose, n));
    if (stage.w_v != 0) d = minus(d, scaled(d_b(n), stage.w_v));
    return plus(reference_speed(pose, n), scaled(d, 1 / stage.k));
  }
};

}  // namespace elastogen
