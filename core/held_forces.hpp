// SPDX-License-Identifier: Apache-2.0
// What held nodes add to the reactions of their holders (core/held_nodes.hpp). Shared by host and
// device.

#pragma once

#include "core/dependent_nodes.hpp"
#include "core/holder.hpp"
#include "core/vec3.hpp"

namespace elastogen {

/// A node that a holder holds.
struct HeldNode {
  int32_t node = 0;
  int32_t dependent = -1;  ///< its number among dependent nodes, -1: it is pinned
  double mass = 0;         ///< of free voxels that it carries, unless it is dependent [kg]
  int32_t parent = -1;     ///< its number among parent nodes, -1: it is none
  uint8_t axes = 7;        ///< bit d: it is held along axis d

  ELASTOGEN_HD bool is_whole() const { return axes == 7; }
};

/// Sums over the nodes of a holder: force [N], moment about a fixed point [N m], displacement [m].
inline constexpr int kHolderSums = 9;
using HolderSums = std::array<double, kHolderSums>;

/// With w_im the weights of parent nodes at dependent ones, the reaction is
///
///     F = sum_i (1 - sum_m w_im) r_i,     M = sum_i ((x_i - c) - sum_m w_im (x_m - c)) x r_i.
///
/// Nodes that are no dependent ones have no weights, and r_n + m (a - g) less load in place of r_n, a
/// the acceleration that the holder gives them.
/// A node that is held along some axes adds these components of r_n alone, with what dependent nodes
/// bring to it.
struct HeldForces {
  const double *rest, *u;  ///< X and x - X [m], (nodes, 3)
  const double* r;         ///< gradient before it is folded [N], (nodes, 3)
  const double* load;      ///< on each node [N], (nodes, 3); null: none
  Vec3 gravity;            ///< [m/s^2]
  WeightedSums dependent;  ///< by dependent node
  WeightedSums parents;    ///< by parent node

  ELASTOGEN_HD static Vec3 at(const double* values, int64_t n) {
    return {values[3 * n], values[3 * n + 1], values[3 * n + 2]};
  }
  ELASTOGEN_HD Vec3 arm(int64_t n, const Vec3& c) const {
    return minus(plus(at(rest, n), at(u, n)), c);
  }
  /// What a node that is no dependent one bears, along its axes.
  ELASTOGEN_HD Vec3 borne(const HeldNode& held, const HolderRate& holder) const {
    const int64_t n = held.node;
    const Vec3 acceleration = holder.acceleration(plus(at(rest, n), at(u, n)));
    Vec3 force = minus(at(r, n), scaled(minus(gravity, acceleration), held.mass));
    if (load) force = minus(force, at(load, n));
    for (int32_t k = held.parent < 0 ? 0 : parents.begin[held.parent];
         held.parent >= 0 && k < parents.begin[held.parent + 1]; ++k)
      force = plus(force, scaled(at(r, parents.sources[k]), parents.weights[k]));
    for (size_t d = 0; d < 3; ++d)
      if (!(held.axes >> d & 1)) force[d] = 0;
    return force;
  }
  /// Adds a node to the kHolderSums sums of its holder.
  /// @param c  the point that moments are about [m].
  ELASTOGEN_HD void add(const HeldNode& held, const HolderRate& holder, const Vec3& c,
                        double* sum) const {
    const int64_t n = held.node;
    double share = 1;
    Vec3 lever = arm(n, c), force = at(r, n);
    if (held.dependent < 0) {
      force = borne(held, holder);
    } else {
      for (int32_t k = dependent.begin[held.dependent]; k < dependent.begin[held.dependent + 1];
           ++k) {
        share -= dependent.weights[k];
        lever = minus(lever, scaled(arm(dependent.sources[k], c), dependent.weights[k]));
      }
    }
    const Vec3 moment = cross(lever, force);
    for (size_t d = 0; d < 3; ++d) {
      sum[d] += share * force[d];
      sum[3 + d] += moment[d];
      sum[6 + d] += u[3 * n + int64_t(d)];
    }
  }
};

}  // namespace elastogen
