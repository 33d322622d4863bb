// SPDX-License-Identifier: Apache-2.0
// Colliders as the nodes of a particle grid feel them: a node inside a collider keeps its motion out
// of it. Coulomb's friction is exact: a node sticks while the force along the wall stays below mu
// times that across it.

#pragma once

#include "core/collider.hpp"
#include "core/mat3.hpp"
#include "mpm_fem/mpm/particle_grid.hpp"

#include <vector>

namespace elastogen::mpm {

struct Wall {
  Collider collider;
  bool sticky = false;  ///< what touches it moves with it, and does not come off
};

/// What one wall asks of a node.
struct NodeWall {
  Vec3 normal = {};
  Vec3 motion = {};  ///< of the wall in the step [m]
  double friction = 0;
  bool sticky = false;
};

class WallContact {
 public:
  /// The nodes inside of walls as these stand at the end of a step.
  template <int d>
  void begin(const ParticleGrid<d>& grid, const std::vector<Wall>& walls, double time, double dt);

  int64_t count() const { return int64_t(node_.size()); }
  int64_t node(int64_t k) const { return node_[size_t(k)]; }

  /// The motion [m] that the k-th node is left with of a motion m without walls: what points into a
  /// wall is taken off, of what goes along it up to friction times as much. Wall by wall.
  /// @param derivative  of the result in m; null: not asked for
  Vec3 allowed(int64_t k, const Vec3& m, Mat3<double>* derivative) const;

  /// The projector onto what no wall holds of that motion: where it sticks none of it, where it
  /// slides what is along the wall.
  Mat3<double> free_part(int64_t k, const Vec3& m) const;

 private:
  std::vector<int32_t> node_;
  std::vector<int32_t> first_;  // wall of each node, (count + 1)
  std::vector<NodeWall> wall_;
};

}  // namespace elastogen::mpm
