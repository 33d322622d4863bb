// SPDX-License-Identifier: Apache-2.0
// Points of the asset's surface against colliders: a barrier in a layer of h/4 below each
// collider's surface, and smoothed friction.
//
//     E = sum_pc A_p kappa b(d_pc / dhat) + sum_pc mu_c N_pc f0(|slip_pc|)
//
// The core of a collider is the collider without its outermost layer of depth dhat. d_pc is the
// distance of point p from the core of collider c, at the collider's position at the end of the
// step. kappa = E dhat^2 / h, so that a voxel in contact is held with a stiffness of about E h. A
// body that only touches feels no force; it sinks by a few per cent of h under its own weight and
// never by more than dhat. N_pc, and the normal across which slip is measured, are from the start
// of the step; slip is relative to the collider.

#pragma once

#include "core/scene.hpp"
#include "core/stage_contact.hpp"

#include <vector>

namespace elastogen {

class Contact {
 public:
  explicit Contact(const Scene& scene);

  bool exists() const { return points_ > 0; }
  /// A_p kappa of each point [J].
  const std::vector<double>& stiffness() const { return stiffness_; }
  const ContactLengths& lengths() const { return lengths_; }
  double start_time() const { return start_time_; }  ///< time at the start of the step [s]

  /// Moves the colliders to the end of a step of length dt that starts at `time`. Finds the normals,
  /// the normal forces and the start of the slip from the displacement u at the start of the step,
  /// (nodes, 3).
  void begin_step(const double* u, double time, double dt);
  void begin_step(const double* u, double time = 0) { begin_step(u, time, scene_.dt); }

  /// begin_step of a stage, with friction as a bond (friction.cpp): slip is measured from where each
  /// point would hold without force, which it keeps from step to step.
  /// @param of_lag  displacement at the time of the lag, which gives normals and normal forces.
  void begin_stage(const double* u, double time, double dt, const double* of_lag, double lag_time);
  /// Takes normals and normal forces of friction from u. @return whether a point rubs, or did before.
  bool renew_lag(const double* u);
  void relax_lag(double share);  ///< goes only a share of the way to what that has found
  /// Keeps the slip of the bonds at u, the end of a step, as far as they hold.
  void keep_bonds(const double* u);
  void forget_bonds() { held_.clear(); }
  Span<const double> bonds() const;  ///< that slip [m], (colliders points, 3); empty: 0

  /// If a collider comes closer to the body than half its distance at the start, moves the nodes
  /// that it can reach along with it, so that they keep their distance. Nodes ahead of which
  /// another collider lies move by the share w = d_other / (d_other + a d), which closes the gap
  /// evenly; a is the cosine between the motion and the direction to the other collider.
  void carry(double* u);

  /// The collider whose core contains a point at u, null if none.
  const Collider* obstacle(const double* u);

  /// Energy [J] at u; adds its gradient [N] to g where g is not null, at pinned nodes only where that
  /// is asked for. Infinite if a point is in the core of a collider.
  template <class T>
  double evaluate(const double* u, T* g, bool at_pinned = false);

  /// Adds up what colliders do at u to each piece.
  /// @param v        velocities of the nodes at the start of the step, for the power of the normal
  ///                 forces [m/s], (nodes, 3).
  /// @param v_stage  velocities at the stage, for that of friction.
  /// @param about    points of the torques, (pieces).
  ActionSums act(const double* u, const double* v, const double* v_stage,
                 const std::vector<Vec3>& about);

  /// Freezes the stiffness at u, along the normal of each point and collider and across it [N/m].
  /// It stays positive, because the rotation of the normal, which lowers it, is left out.
  void linearise(const double* u);
  /// Adds the frozen Hessian times p to f.
  void add_hessian_product(const float* p, float* f) const;
  /// Nodes with frozen stiffness, and their row sums of it: symmetric 3x3 blocks [N/m],
  /// (stiff nodes, 9).
  const std::vector<int32_t>& stiff_nodes() const { return stiff_nodes_; }
  const std::vector<double>& stiff_blocks() const { return stiff_blocks_; }

  /// Largest share, at most 1, of the straight path from u to `end` along which each point keeps at
  /// least 10 % of its distance.
  double longest_step(const double* u, const double* end);

  /// Largest depth of a point below a collider's surface [m], 0 if none.
  double deepest_overlap(const double* u);

  /// Calls body(corners, weights, stiffness) for each frozen point.
  template <class Body>
  void for_each_frozen(const Body& body) const {
    for (const auto& [p, k] : active_)
      body(scene_.grid.corners.row(scene_.surface.voxel(p)), scene_.surface.weights.row(p), k);
  }

 private:
  struct Obstacle : ObstaclePath {
    Collider core = {};
    bool rubs = false;  // friction acts on some point
  };
  /// Frozen stiffness of a point at a collider.
  struct Frozen {
    int64_t point = 0;
    PointStiffness k = {};
  };
  struct Ball {
    Vec3 centre = {};
    double radius = 0;
  };
  Vec3 place_of(int64_t p, const double* u) const;
  Vec3 carried(int64_t p, const double* values) const;
  Ball find_places(const double* u, std::vector<Vec3>& places);
  bool reaches(const Obstacle& obstacle, const Ball& body, double within) const;
  void find_distances(const Obstacle& obstacle, const Vec3& offset);
  const ContactLag& lag(size_t obstacle, int64_t p) const {
    return lags_[obstacle * size_t(points_) + size_t(p)];
  }
  /// A point at an obstacle; the slip of its bond counts as slip of the step.
  ContactPoint point(size_t obstacle, int64_t p) const {
    ContactPoint result = {place_[size_t(p)], start_[size_t(p)], stiffness_[size_t(p)]};
    if (lengths_.bond == 0) return result;
    const Vec3& slip = slip_[obstacle * size_t(points_) + size_t(p)];
    for (size_t d = 0; d < 3; ++d) result.start[d] -= slip[d];
    return result;
  }
  void set_lag(const double* u, double time);
  bool crowds(const Obstacle& obstacle, double motion);
  void add_nodal(const Frozen& frozen);

  const Scene& scene_;
  std::vector<Obstacle> obstacles_;
  int64_t points_ = 0;
  double start_time_ = 0, dt_ = 0;
  ContactLengths lengths_;
  double slip_range_ = 0;                     // in a step of the scene's dt
  std::vector<double> stiffness_;             // of each point [J]
  std::vector<ContactLag> lags_, last_lags_;  // collider by collider; before renew_lag()
  std::vector<Vec3> held_, slip_;             // of the bonds, kept and in the present step
  std::vector<Vec3> start_, place_, end_;     // of each point [m]
  std::vector<Box> boxes_;                    // of blocks of points
  std::vector<Proximity> near_;   // of each point, to the core of one collider at a time
  std::vector<uint8_t> carried_;  // nodes
  std::vector<Frozen> active_;
  std::vector<int32_t> stiff_nodes_, stiff_place_;  // stiff_place_: of each node, -1 if none
  std::vector<double> stiff_blocks_;
};

}  // namespace elastogen
