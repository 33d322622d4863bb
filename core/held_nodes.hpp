// SPDX-License-Identifier: Apache-2.0
// Where holders put the nodes of a scene. With ubar the displacement that a holder gives a point,
//
//     pinned     u_n = ubar(X_n),
//     dependent  u_i = ubar(X_i) + sum_m w_im (u_m - ubar(X_m)),     m the parent nodes of i,
//
// so that the field meets the motion of the border on the border (core/dependent_nodes.hpp). Where
// no holder moves ubar is 0.

#pragma once

#include "core/scene.hpp"

#include <vector>

namespace elastogen {

class HeldNodes {
 public:
  /// The scene must be finished and outlive it.
  explicit HeldNodes(const Scene& scene);

  /// Whether a holder moves.
  bool move() const { return !moved_.empty() || !offset_.empty(); }
  /// Whether one moves dependent nodes.
  bool moves_dependent() const { return !offset_.empty(); }
  /// What a dependent node has beside that from its parent nodes [m], by its number.
  const Vec3& offset(int64_t i) const { return offset_[size_t(i)]; }
  /// Takes what holders do at a time [s], as all that follows does.
  void set_time(double time);

  /// Sets displacements of pinned nodes that move, (nodes, 3) [m].
  void place_pinned(double* u) const;
  /// Sets those of dependent nodes.
  void follow(double* u) const;
  void place(double* u) const { place_pinned(u), follow(u); }  ///< sets both
  /// Fills values that holders do not move, like directions (DependentNodes::fill).
  void fill(double* values) const { scene_.dependent.fill(values); }
  /// Sets velocities of pinned nodes that move, at positions x [m/s], (nodes, 3).
  void set_velocities(const double* x, double* v) const;

  /// What each holder does to the free part of the body, conjugate to its rigid motion: at a pinned
  /// node r_n, less its load and the weight of voxels that have nodes which are not pinned, and of
  /// dependent nodes
  ///
  ///     F = sum_i (1 - sum_m w_im) r_i,     M = sum_i ((x_i - c) - sum_m w_im (x_m - c)) x r_i,
  ///
  /// c the centre of a turn, else the mean of the nodes held. In a fixed order.
  /// @param r  gradient of the potential before it is folded [N], at pinned nodes of the inner
  ///           forces alone, (nodes, 3).
  /// @param u  displacement [m], (nodes, 3).
  /// @param load  on each node [N], (nodes, 3); null: none.
  std::vector<Reaction> reactions(const double* r, const double* u, const double* load) const;
  /// Power of what holders that move do to the body, the weight of what they hold included [W].
  double power(const std::vector<Reaction>& reactions) const;

 private:
  void find_weights();
  const Holder& holder_of(int64_t node) const;
  Vec3 rest(int64_t node) const;
  Vec3 centre(size_t holder, const double* u) const;

  const Scene& scene_;
  double time_ = 0;
  std::vector<int32_t> moved_;               // pinned nodes of holders that move
  std::vector<Vec3> place_;                  // ubar of these
  std::vector<double> weighing_;             // mass of each node that weighs on its holder [kg]
  std::vector<Vec3> offset_;                 // ubar(X_i) - sum w_im ubar(X_m), of dependent nodes
  std::vector<std::vector<int32_t>> nodes_;  // pinned nodes of each holder
  std::vector<std::vector<int32_t>> dependent_;  // dependent nodes of each holder, as numbers
};

}  // namespace elastogen
