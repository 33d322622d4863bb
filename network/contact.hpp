// SPDX-License-Identifier: Apache-2.0
// Points of the asset's surface against the floor: a barrier in a layer of h/4 below the floor's
// plane, and smoothed friction.
//
//     E = sum_p A_p kappa b(d_p / dhat) + sum_p mu N_p f0(|slip_p|),   d_p = n.x_p - offset + dhat
//
// kappa = E dhat^2 / h, so that a voxel in contact is held with a stiffness of about E h. A body
// that stands exactly on the plane feels no force; it sinks by a few per cent of h under its own
// weight and never by more than dhat = h/4. N_p is the normal force at the start of the step.

#pragma once

#include "core/barrier.hpp"
#include "core/scene.hpp"

#include <vector>

namespace elastogen {

/// Depth dhat of the contact layer below the plane, h/4 [m].
double contact_layer(const Scene& scene);

/// Slip within a step [m] up to which friction counts as sticking: a thousandth of the body's
/// free-fall speed times dt.
double slip_range(const Scene& scene);

class Contact {
 public:
  explicit Contact(const Scene& scene);

  bool exists() const { return points_ > 0; }

  /// Takes slip and normal forces from the displacement u at the start of the step, (nodes, 3).
  void begin_step(const double* u);

  /// Energy [J] at u; adds its gradient [N] to g where g is not null. Infinite if a point is on or
  /// behind the wall.
  template <class T>
  double evaluate(const double* u, T* g);

  /// Freezes the positive stiffness at u: per point along the normal and across it [N/m].
  void linearise(const double* u);
  /// Adds the frozen Hessian times p to f.
  void add_hessian_product(const float* p, float* f) const;
  /// Nodes with frozen stiffness, and the row sums of it, symmetric 3x3 blocks [N/m], (stiff nodes,
  /// 9).
  const std::vector<int32_t>& stiff_nodes() const { return stiff_nodes_; }
  const std::vector<double>& stiff_blocks() const { return stiff_blocks_; }

  /// Largest share, at most 1, of the way from u to `end` that leaves each point 10 % of its
  /// distance.
  double longest_step(const double* u, const double* end) const;

  /// Deepest place of a point below the plane [m], 0 if none.
  double deepest_overlap(const double* u) const;

  const Vec3& normal() const { return floor_.normal; }

 private:
  /// Frozen stiffness of a point [N/m]: along the normal, along the slip, across both.
  struct PointStiffness {
    int64_t point = 0;
    double normal = 0, along = 0, across = 0;
    double direction[3] = {};  // unit vector of the slip, 0 where there is none
  };
  double height(int64_t p) const;
  void move_of(int64_t p, const double* u, double result[3]) const;
  double normal_motion(int64_t p, const double* u) const;
  double slip_of(int64_t p, const double* u, double slip[3]) const;
  bool acts(int64_t p) const;
  bool rubs(int64_t p) const;
  double point_energy(int64_t p, const double* u, double force[3]) const;
  void add_nodal(const PointStiffness& k);

  const Scene& scene_;
  Floor floor_;
  int64_t points_ = 0;
  double layer_ = 0;       // dhat [m]
  double slip_range_ = 0;  // e of smoothed_slip [m]
  std::vector<double> distance_, normal_force_, stiffness_;
  std::vector<double> start_;  // displacement of each point at the start of the step
  std::vector<PointStiffness> active_;
  std::vector<int32_t> stiff_nodes_, stiff_place_;  // stiff_place_: of each node, -1 if none
  std::vector<double> stiff_blocks_;
};

}  // namespace elastogen
