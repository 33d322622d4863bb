// SPDX-License-Identifier: Apache-2.0
// Where holders put the nodes of a scene. With ubar the displacement that a holder gives a point,
//
//     pinned     u_n = ubar(X_n),
//     dependent  u_i = ubar(X_i) + sum_m w_im (u_m - ubar(X_m)),     m the parent nodes of i,
//
// so that the field meets the motion of the border on the border (core/dependent_nodes.hpp). Where
// no holder moves ubar is 0. Single components of free nodes may be fixed at 0 (Scene::fixed): with
// the free unknowns y, u = C y + c(t).

#pragma once

#include "core/held_forces.hpp"
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
  double time() const { return time_; }

  /// Sets displacements of pinned nodes that move, and fixed components, (nodes, 3) [m].
  void place_pinned(double* u) const;
  /// Sets those of dependent nodes, and fixed components.
  void follow(double* u) const;
  void place(double* u) const { place_pinned(u), follow(u); }  ///< sets both
  /// Adds to velocities of dependent nodes what holders bring at the start, as they go on for a time
  /// [s] (a holder rests before it).
  void add_start_rates(double soon, double* v);
  /// C y, of values that holders do not move, like directions (DependentNodes::fill).
  template <class T>
  void fill(T* values) const {
    fix(values);
    scene_.dependent.fill(values);
  }
  /// C^T g (DependentNodes::fold).
  template <class T>
  void fold(T* gradient) const {
    scene_.dependent.fold(gradient);
    fix(gradient);
  }
  /// Sets velocities of pinned nodes that move, at positions x [m/s], (nodes, 3).
  void set_velocities(const double* x, double* v) const;

  /// What each holder does to the free part of the body, with the nodes in it that are pinned,
  /// conjugate to its rigid motion: the sums of
  /// HeldForces over its nodes, in a fixed order; c is the centre of a turn, else the mean of these
  /// nodes.
  /// @param r  gradient of the potential before it is folded [N], at pinned nodes of the inner
  ///           forces alone, (nodes, 3).
  /// @param u  displacement [m], (nodes, 3).
  /// @param load  on each node [N], (nodes, 3); null: none.
  std::vector<Reaction> reactions(const double* r, const double* u, const double* load) const;
  /// The same of sums that another machine has made, about centres() and (holders).
  std::vector<Reaction> reactions(const std::vector<HolderSums>& sums) const;
  /// Power of what holders that move do to the body, the weight of what they hold included, their
  /// nodes' kinetic energy not [W].
  double power(const std::vector<Reaction>& reactions) const;

  // for other machines

  /// Bit d: component d of a node is fixed.
  uint8_t fixed_axes(int64_t node) const {
    uint8_t axes = 0;
    for (int d = 0; d < 3 && !fixed_.empty(); ++d)
      axes |= uint8_t((scene_.fixed(node, d) >= 0) << d);
    return axes;
  }
  /// Fixed components, 3 n + d.
  const std::vector<int32_t>& fixed() const { return fixed_; }
  /// Pinned nodes that move, the holder of each, and u there.
  const std::vector<int32_t>& moved() const { return moved_; }
  const std::vector<int32_t>& holders_of_moved() const { return holders_of_moved_; }
  const std::vector<Vec3>& places() const { return place_; }
  /// offset() of all dependent nodes; empty: none moves.
  const std::vector<Vec3>& offsets() const { return offset_; }
  /// Of each holder its motion, its nodes, and the point that its sums are about.
  const std::vector<HolderRate>& rates() const { return rates_; }
  const std::vector<std::vector<HeldNode>>& nodes() const { return nodes_; }
  const std::vector<Vec3>& centres() const { return centres_; }

 private:
  template <class T>
  void fix(T* values) const {
    for (const int32_t k : fixed_) values[k] = 0;
  }
  void find_fixed();
  void find_weights();
  void find_centres();
  const Holder& holder_of(int64_t node) const;
  Vec3 rest(int64_t node) const;

  const Scene& scene_;
  double time_ = 0;
  std::vector<int32_t> moved_, holders_of_moved_, fixed_;
  std::vector<Vec3> place_;                   // ubar of moved_
  std::vector<double> weighing_;              // mass of each node that weighs on its holder [kg]
  std::vector<Vec3> offset_;                  // ubar(X_i) - sum w_im ubar(X_m), of dependent nodes
  std::vector<HolderRate> rates_;             // (holders), as what follows
  std::vector<std::vector<HeldNode>> nodes_;  // pinned, dependent, then those of some axes
  std::vector<Vec3> centres_;                 // of turns, else the mean of the nodes at rest
};

}  // namespace elastogen
