// SPDX-License-Identifier: Apache-2.0
// Points of a surface against colliders: the barrier and the smoothed friction of docs/physics.md,
// section 6,
//
//     E = sum_pc A_p kappa_p b(d_pc / D) + sum_pc friction_c N_pc f(|slip_pc|),
//
// d_pc is the distance of point p from the core of collider c at the end of the step. N_pc, and the
// normal across which slip is measured, are from the start of the step. Gradient and Hessian are
// exact except for the rotation of a convex collider's normal, which would only lower the Hessian.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"
#include "mpm_fem/solve/term.hpp"

namespace elastogen::fem {

/// Points that move with nodes of a mesh.
struct ContactPoints {
  Array<int32_t> nodes;     ///< nodes that carry a point, (points, n)
  Array<double> weights;    ///< of each, rows sum to 1, (points, n)
  Array<double> area;       ///< [m^2], (points, 1)
  Array<double> position;   ///< at rest [m], (points, 3)
  Array<double> stiffness;  ///< E D^2 / h of the barrier [N/m], (points, 1)
  double layer = 0;         ///< D [m]
  double slip_range = 0;    ///< slip up to which friction counts as sticking [m]
};

/// The points of a voxel scene with its layer h/4 and its slip range, a thousandth of the body's
/// free-fall speed times dt; the corners of its voxel carry each point.
ContactPoints voxel_contact(const Scene& scene);

/// Nodes of a mesh as points, each as stiff as the stiffest of its elements; h of layer and slip
/// range is the scene's.
/// @param scene  with materials, grid.h, dt, and area and position of the points in its surface.
/// @param nodes  of each point, (points, 1).
ContactPoints node_contact(const Scene& scene, const ElementMesh& mesh, In<int32_t> nodes);

class ColliderContact final : public Term {
 public:
  /// @throws Error where arrays differ in length or a node is not there.
  ColliderContact(ContactPoints points, std::vector<Collider> colliders, int64_t nodes);

  bool exists() const { return !obstacles_.empty(); }

  /// Finds the normals, the normal forces and the start of the slip from the displacement u,
  /// (nodes, 3), at the start of a step from `time` to `time + dt`, and moves the colliders to its
  /// end.
  /// @param share  dt over the time step that the slip range of the points is for
  void begin_step(In<double> u, double time, double dt, double share = 1);

  /// Moves the colliders to the end of a step from `time` to `time + dt`, without friction:
  /// explicit steps apply that by rub().
  void stand_without_friction(double time, double dt);
  /// Reduces the velocities v [m/s], (nodes, 3), by the friction in that step: along a collider by
  /// at most friction N dt/m, N the push at u. Each point must be carried by one node.
  void rub(In<double> u, In<double> mass, double dt, Out<double> v);
  /// Push of the barrier of each collider on the points [N], without friction.
  std::vector<Vec3> pushes(In<double> u);

  /// Moves the colliders to a share of their path through the step. Where they would run into a
  /// start value, the solver moves them on share by share.
  void stand_at(double share);
  /// Largest share above `from` at which each point keeps half its distance at `from`; `from` if
  /// there is none.
  double clear_share(In<double> u, double from);

  /// Energy [J]; infinite where a point is in the core of a collider.
  double energy(In<double> u);

  /// The nodes that carry each point, whether it is near a collider or not.
  const Stencils& stencils() const override { return stencils_; }
  TermValue value(In<double> u) override;
  void add_gradient(In<double> u, Out<double> g) override;
  /// Adds one Hessian for both kinds.
  void add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) override;
  /// The share of the path along which each point keeps at least a tenth of its distance.
  double longest_step(In<double> u, In<double> end) override;

  /// Largest depth of a point below a collider's surface [m], 0 if none.
  double deepest_overlap(In<double> u);
  /// The collider whose core contains a point, null if none.
  const Collider* obstacle(In<double> u);

 private:
  struct Obstacle {
    Collider core;
    Vec3 from = {}, to = {}, now = {};  // offsets at the start, at the end and at stand_at's share
  };
  /// Data of friction from the start of the step.
  struct Lag {
    double limit = 0;  // largest force [N]
    Vec3 normal = {};
  };
  /// A point near a collider: distance, normal, slip across the lagged normal.
  struct Touch {
    int64_t point;
    const Obstacle* obstacle;
    const Lag* lag;
    double distance;
    Vec3 normal, slip;
  };

  Vec3 place(In<double> u, int64_t point) const;
  void find_touches(In<double> u);
  double push_of(const Touch& touch) const;
  Touch touch_of(const Obstacle& obstacle, const Lag& lag, int64_t point, const Vec3& place) const;
  void hessian_of(const Touch& touch, double block[9]) const;

  ContactPoints points_;
  Stencils stencils_;
  std::vector<Obstacle> obstacles_;
  std::vector<Lag> lags_;    // collider by collider
  std::vector<Vec3> start_;  // position of each point at the start of the step
  std::vector<Touch> touches_;
  double slip_range_ = 0;  // of the present step [m]
};

}  // namespace elastogen::fem
