// SPDX-License-Identifier: Apache-2.0
// Contact of the nodes of a particle grid with colliders: a node inside a collider does not move
// into it. Coulomb's friction is exact: a node sticks while the force along the collider stays
// below mu times that across it. A pin is an obstacle that all nodes behind its border stick to.

#pragma once

#include "core/collider.hpp"
#include "core/mat3.hpp"
#include "mpm_fem/mpm/particle_grid.hpp"
#include "voxelize/border.hpp"

#include <optional>
#include <vector>

namespace elastogen::mpm {

struct Obstacle {
  Collider collider;
  bool sticky = false;              ///< nodes that touch it move with it and do not come off
  std::optional<Border> held = {};  ///< a pin, not a collider: nodes behind it stay
};

/// Contact of a node with one collider.
struct NodeObstacle {
  Vec3 normal = {};
  Vec3 motion = {};  ///< of the collider in the step [m]
  double friction = 0;
  bool sticky = false;
};

class ObstacleContact {
 public:
  /// Finds the nodes inside colliders, where these are at the end of a step.
  template <int d>
  void begin(const ParticleGrid<d>& grid, const std::vector<Obstacle>& obstacles, double time,
             double dt);

  int64_t count() const { return int64_t(node_.size()); }
  int64_t node(int64_t k) const { return node_[size_t(k)]; }

  /// The part of a motion m [m] that colliders leave the k-th node. One collider after the other
  /// removes the motion into it, and up to friction times as much of the motion along it.
  /// @param derivative  of the result in m; null: not wanted
  Vec3 allowed(int64_t k, const Vec3& m, Mat3<double>* derivative) const;

  /// The projector onto the directions of that motion that no collider holds: none where the node
  /// sticks, those along the collider where it slides.
  Mat3<double> free_part(int64_t k, const Vec3& m) const;

 private:
  std::vector<int32_t> node_;
  std::vector<int32_t> first_;  // first contact of each node in obstacle_, (count + 1)
  std::vector<NodeObstacle> obstacle_;
};

}  // namespace elastogen::mpm
