// SPDX-License-Identifier: Apache-2.0
// Points of a surface against colliders: the barrier and the smoothed friction of docs/physics.md,
// section 6,
//
//     E = sum_pc A_p kappa_p b(d_pc / D) + sum_pc friction_c N_pc f(|slip_pc|),
//
// d_pc is the distance of point p from the core of collider c at the end of the step. N_pc, and the
// normal across which slip is measured, are from the start of the step. Gradient and Hessian are
// exact except for the rotation of a convex collider's normal, which would only lower the Hessian.
// Stages have friction of another kind, bonds (bond_friction.cpp).

#pragma once

#include "core/barrier.hpp"
#include "mpm_fem/contact/contact_points.hpp"
#include "mpm_fem/solve/term.hpp"

namespace elastogen::fem {

/// What a collider does to a point.
struct PointForce {
  int32_t node = 0;    ///< one that carries the point
  Vec3 place = {};     ///< [m]
  Vec3 force = {};     ///< with friction [N]
  double push = 0;     ///< force along the normal [N]
  double energy = 0;   ///< of the barrier [J]
  double closing = 0;  ///< speed against the collider [m/s]
  double rubbed = 0;   ///< power of sliding against friction [W]
  double driven = 0;   ///< power of the collider: the force times its velocity [W]
  double bond = 0;     ///< energy that its bond would hold, where a step ends there [J]
};

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

  /// begin_step of a stage that ends at `time + dt`, with friction by bonds. Rows of points are
  /// collider by collider.
  /// @param lag_u  displacement at lag_time, which gives normals and normal forces
  /// @param held   slip of the bonds at u [m], (colliders * points, 3); empty: 0
  void begin_stage(In<double> u, double time, double dt, In<double> lag_u, double lag_time,
                   In<double> held);
  /// Takes normals and normal forces of friction from u, at the end of the stage.
  /// @return whether any point rubs, or did before
  bool renew_lags(In<double> u);
  void relax_lags(double share);  ///< goes a share of the way from the lags before renew_lags()
  /// Slip that bonds hold at u, the end of a step: what the next begin_stage gets.
  Array<double> bonds(In<double> u);
  /// What colliders do at u to the points that they touch, in a stage.
  /// @param v        velocities for the closing speed [m/s], (nodes, 3)
  /// @param v_stage  those at the stage, for the power of friction
  std::vector<PointForce> forces(In<double> u, In<double> v, In<double> v_stage);

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
  /// Adds one Hessian for both kinds, but for bonds that yield.
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
  /// Data of friction from the start of the step, or from the end of a stage.
  struct Lag {
    double limit = 0;  // largest force [N]
    Vec3 normal = {};
    Vec3 bond = {};  // slip that it holds at the start of the step [m]
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
  Vec3 carried(In<double> field, int64_t point) const;
  void move(In<double> u, double time, double dt);
  void set_lags(In<double> u, double time);
  double longest_bond(int64_t point, double limit) const;
  Vec3 bonded(const Lag& lag, int64_t point, const Vec3& slip) const;
  void set_bonds();
  bool rubs() const;
  SmoothedSlip friction_of(const Touch& touch) const;
  void find_touches(In<double> u);
  double push_of(const Touch& touch) const;
  Touch touch_of(const Obstacle& obstacle, const Lag& lag, int64_t point, const Vec3& place) const;
  void hessian_of(const Touch& touch, TangentKind kind, double block[9]) const;

  ContactPoints points_;
  Stencils stencils_;
  std::vector<Obstacle> obstacles_;
  std::vector<Lag> lags_, last_lags_;  // collider by collider
  std::vector<Vec3> start_;            // position of each point at the start of the step
  std::vector<Touch> touches_;
  double slip_range_ = 0;  // of the present step [m]
  // of bonds: k_t over A kappa [1/m^2], 0: friction is smoothed; the slip that they hold at the
  // start of the step [m], (lags, 3); end and length of the stage [s]
  double bond_ = 0;
  Array<double> held_;
  double end_ = 0, dt_ = 0;
};

}  // namespace elastogen::fem
