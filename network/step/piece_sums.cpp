// SPDX-License-Identifier: Apache-2.0
#include "network/step/piece_sums.hpp"

#include "network/step/free_flight.hpp"

#include <algorithm>

namespace elastogen {

Pieces::Pieces(const Scene& scene) : held_(held_pieces(scene)) {
  const Array<double>& X = scene.grid.rest;
  nodes_ = grouped(scene.grid.node_count(), size_t(scene.grid.pieces),
                   [&](int64_t n) { return scene.grid.piece(n); });
  mass_.resize(count());
  size_.resize(count());
  pins_.resize(count());
  is_bound_.resize(count());
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    is_bound_[size_t(scene.grid.piece(scene.dependent.node(i)))] = 1;
  for (int64_t k = 0; k < scene.fixed.size(); ++k)
    if (scene.fixed.data()[k] >= 0) is_bound_[size_t(scene.grid.piece(k / 3))] = 1;
  for (size_t p = 0; p < count(); ++p) {
    // mass and centre, pins, then distances from the centre
    const auto whole = sum<4>(p, [&](int64_t n, auto& s) {
      for (size_t i = 0; i < 3; ++i) s[i] += scene.mass(n) * X(n, int(i));
      s[3] += scene.mass(n);
    });
    mass_[p] = whole[3];
    const auto pinned = sum<4>(p, [&](int64_t n, auto& s) {
      if (!scene.pinned(n)) return;
      for (size_t i = 0; i < 3; ++i) s[i] += X(n, int(i));
      s[3] += 1;
    });
    for (size_t i = 0; i < 3 && pinned[3] > 0; ++i) pins_[p][i] = pinned[i] / pinned[3];
    const auto square = sum<1>(p, [&](int64_t n, auto& s) {
      for (size_t i = 0; i < 3; ++i)
        s[0] += scene.mass(n) * std::pow(X(n, int(i)) - whole[i] / whole[3], 2);
    });
    size_[p] = 2 * std::sqrt(square[0] / mass_[p]);
  }
}

RigidMotion rigid_motion(const PieceState& state) {
  RigidMotion motion{state.centre, state.velocity, state.spin, inverse(state.inertia)};
  for (const double value : motion.per_inertia.m)
    if (!std::isfinite(value)) motion.per_inertia = {}, motion.spin = {};
  return motion;
}

Vec3 spin_about(const PieceState& state, double mass, const Vec3& point) {
  const Vec3 arm = minus(state.centre, point);
  PieceState about = state;  // moments of the mass in the centre are added
  about.spin = plus(state.spin, scaled(cross(arm, state.velocity), mass));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      about.inertia(i, j) +=
          mass * ((i == j ? dot(arm, arm) : 0) - arm[size_t(i)] * arm[size_t(j)]);
  const RigidMotion motion = rigid_motion(about);
  return times(motion.per_inertia, motion.spin);
}

double spin_square(const PieceState& state) {
  return dot(state.spin, times(rigid_motion(state).per_inertia, state.spin));
}

}  // namespace elastogen
