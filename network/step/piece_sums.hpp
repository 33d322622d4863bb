// SPDX-License-Identifier: Apache-2.0
// The pieces of a body: their nodes, masses and sizes, and the motion of each as a rigid body.

#pragma once

#include "core/parallel.hpp"
#include "core/rigid_motion.hpp"
#include "core/scene.hpp"

#include <array>
#include <vector>

namespace elastogen {

/// A piece at one time.
struct PieceState {
  Vec3 centre = {};           ///< of mass [m]
  Vec3 velocity = {};         ///< of it [m/s]
  Vec3 spin = {};             ///< angular momentum about the centre [kg m^2/s]
  Mat3<double> inertia = {};  ///< moments about it [kg m^2]
};

class Pieces {
 public:
  explicit Pieces(const Scene& scene);

  size_t count() const { return nodes_.size(); }
  /// No node of the piece is pinned, or fixed along an axis.
  bool is_free(size_t piece) const { return !held_[piece]; }
  /// No node is pinned or depends on others: the piece is free but for components that are fixed.
  bool is_loose(size_t piece) const { return is_loose_[piece]; }
  /// Mean place of what pins a piece at rest, where it stays [m]: of pinned nodes, and of the points
  /// of a border that dependent nodes follow from, (X_i - sum w_im X_m) / (1 - sum w_im).
  const Vec3& pins(size_t piece) const { return pins_[piece]; }
  /// What is left of the velocity of a piece without components along which nodes are fixed.
  Vec3 slide(size_t piece, Vec3 velocity) const;
  /// The motion of a piece without forces from a state on, that its fixed components admit whatever
  /// nodes have them: along the other axes, and about the axis of the only one.
  RigidMotion rigid_motion(size_t piece, const PieceState& state) const;
  /// sum m |w x r|^2 of the spin w of that motion [J].
  double spin_square(size_t piece, const PieceState& state) const;
  /// Angular velocity of a piece about its pins, weighted with mass [rad/s].
  Vec3 turn_about_pins(size_t piece, const PieceState& state) const;
  double mass(size_t piece) const { return mass_[piece]; }  ///< [kg]
  /// Twice the rms distance of its nodes from the centre at rest [m], weighted with mass.
  double size(size_t piece) const { return size_[piece]; }

  /// Adds value(node, sum) over the nodes of a piece in a fixed order.
  template <size_t kCount, class Value>
  std::array<double, kCount> sum(size_t piece, const Value& value) const {
    const std::vector<int32_t>& nodes = nodes_[piece];
    const auto n = int64_t(nodes.size());
    std::vector<std::array<double, kCount>> parts(size_t((n + kBlock - 1) / kBlock));
    for_blocks(n, [&](int64_t begin, int64_t end) {
      std::array<double, kCount>& part = parts[size_t(begin / kBlock)] = {};
      for (int64_t k = begin; k < end; ++k) value(int64_t(nodes[size_t(k)]), part);
    });
    std::array<double, kCount> total = {};
    for (const auto& part : parts)
      for (size_t k = 0; k < kCount; ++k) total[k] += part[k];
    return total;
  }

  /// Nodes of each piece.
  const std::vector<std::vector<int32_t>>& nodes() const { return nodes_; }
  /// Scene::pinned, (nodes), with nodes that are fixed along all axes as pinned ones.
  const std::vector<uint8_t>& kinds() const { return kinds_; }

 private:
  void find_holds(const Scene& scene);
  void find_masses(const Scene& scene);
  void find_pins(const Scene& scene);

  std::vector<std::vector<int32_t>> nodes_;
  std::vector<uint8_t> kinds_, held_, is_loose_;
  std::vector<uint8_t> axes_;  // bit d: component d of a node is fixed, of one that is not pinned
  std::vector<double> mass_, size_;
  std::vector<Vec3> pins_;
};

}  // namespace elastogen
