// SPDX-License-Identifier: Apache-2.0
// The connected pieces of a mesh as bodies, by the mass matrix M of the time steps, lumped or
// consistent. With r from the centre of mass c, sums over the nodes of a piece,
//
//     m = sum M 1,   c = sum (M x) / m,   V = sum (M v) / m,
//     L = sum r x (M v),   I = sum (r . M r) 1 - r (M r)^T.

#pragma once

#include "core/rigid_motion.hpp"
#include "mpm_fem/fem_scene.hpp"
#include "mpm_fem/solve/mass_matrix.hpp"

namespace elastogen::fem {

/// A node's entries of a field (nodes, 3).
inline Vec3 row_of(In<double> field, int64_t node) {
  return {field(node, 0), field(node, 1), field(node, 2)};
}

/// A piece at one time.
struct PieceMotion {
  Vec3 centre = {};           ///< of mass [m]
  Vec3 velocity = {};         ///< of it [m/s]
  Vec3 spin = {};             ///< angular momentum about it [kg m^2/s]
  Mat3<double> inertia = {};  ///< moments about it [kg m^2]
};

class FemPieces {
 public:
  /// Both must outlive it.
  /// @throws Error where a node belongs to no element, unless borders of dependent nodes hold it
  FemPieces(const FemScene& scene, const MassMatrix& mass);

  size_t count() const { return mass_.size(); }
  size_t of(int64_t node) const { return size_t(piece_(node)); }
  /// No node of the piece is held whole or dependent, and single components that are stay at 0.
  bool is_loose(size_t piece) const { return loose_[piece]; }
  /// Nodes of the piece stay at their places, or depend on others.
  bool is_pinned(size_t piece) const { return pinned_[piece]; }
  /// Mean place of the former and of the points (X_i - sum w_im X_m)/(1 - sum w_im) of the latter [m].
  const Vec3& pins(size_t piece) const { return pins_[piece]; }
  double mass(size_t piece) const { return mass_[piece]; }  ///< [kg]
  /// Twice the rms distance of a piece from its centre at rest [m].
  double size(size_t piece) const { return size_[piece]; }

  /// All pieces where displacements are u and velocities v, both (nodes, 3).
  std::vector<PieceMotion> motions(In<double> u, In<double> v) const;
  /// sqrt(y.M y / m) of each piece, y (nodes, 3).
  std::vector<double> rms(In<double> y) const;
  /// y.M z
  double product(In<double> y, In<double> z) const;
  /// The motion of a loose piece without forces from there on, along the axes of which no component is
  /// prescribed, and about the axis of the only one that is.
  RigidMotion rigid_motion(size_t piece, const PieceMotion& motion) const;
  /// Angular velocity of a piece about its pins, weighted with mass [rad/s].
  Vec3 turn_about_pins(size_t piece, const PieceMotion& motion) const;
  /// Writes V + w x r, the rigid motion of least distance from a field whose momenta `motion` has,
  /// on loose pieces, 0 on the others.
  Array<double> rigid_part(In<double> u, const std::vector<PieceMotion>& motion) const;

 private:
  void find_masses();
  void find_holds();
  void find_pins();
  Mat3<double> per_inertia(size_t piece, const Mat3<double>& inertia) const;
  Array<double> multiplied(In<double> y) const;

  const FemScene& scene_;
  const MassMatrix& matrix_;
  Array<int32_t> piece_;
  Array<double> node_mass_;     // M 1 [kg], (nodes, 1)
  std::vector<int64_t> first_;  // node of each piece
  std::vector<uint8_t> loose_, pinned_;
  std::vector<std::array<bool, 3>> stops_;  // axes along which single components are prescribed
  std::vector<double> mass_, size_;
  std::vector<Vec3> pins_;
};

}  // namespace elastogen::fem
