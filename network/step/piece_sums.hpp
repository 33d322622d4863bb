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
  /// Mean place of a piece's pinned nodes at rest, where they stay [m].
  const Vec3& pins(size_t piece) const { return pins_[piece]; }
  /// Nodes of the piece depend on others or are fixed along an axis: no turn about the pins meets what
  /// they must.
  bool is_bound(size_t piece) const { return is_bound_[piece]; }
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

 private:
  std::vector<std::vector<int32_t>> nodes_;
  std::vector<uint8_t> held_, is_bound_;
  std::vector<double> mass_, size_;
  std::vector<Vec3> pins_;
};

/// sum m |w x r|^2 of the spin w of a piece [J].
double spin_square(const PieceState& state);

/// The motion of a free piece without forces from there on.
RigidMotion rigid_motion(const PieceState& state);

/// Angular velocity of a piece about a point, weighted with mass [rad/s].
Vec3 spin_about(const PieceState& state, double mass, const Vec3& point);

}  // namespace elastogen
