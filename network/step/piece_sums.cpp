// SPDX-License-Identifier: Apache-2.0
#include "network/step/piece_sums.hpp"

#include "network/step/free_flight.hpp"

#include <algorithm>
#include <bit>

namespace elastogen {
namespace {

constexpr uint8_t kAllAxes = 7;

}  // namespace

Pieces::Pieces(const Scene& scene)
    : nodes_(grouped(scene.grid.node_count(), size_t(scene.grid.pieces),
                     [&](int64_t n) { return scene.grid.piece(n); })),
      held_(held_pieces(scene)) {
  find_holds(scene);
  find_masses(scene);
  find_pins(scene);
}

/// Which pieces have pinned or dependent nodes, and along which axes others are fixed.
void Pieces::find_holds(const Scene& scene) {
  kinds_.assign(scene.pinned.data(), scene.pinned.data() + scene.grid.node_count());
  is_loose_.assign(count(), 1);
  axes_.assign(count(), 0);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const auto p = size_t(scene.grid.piece(n));
    uint8_t axes = 0;
    for (int d = 0; d < 3 && !scene.fixed.empty(); ++d)
      if (scene.fixed(n, d) >= 0) axes |= uint8_t(1 << d);
    if (axes == kAllAxes) kinds_[size_t(n)] = kPinnedNode;
    if (axes != kAllAxes) axes_[p] |= axes;
    if (kinds_[size_t(n)] != kFreeNode) is_loose_[p] = 0;
  }
}

/// Masses, and from the centre sizes.
void Pieces::find_masses(const Scene& scene) {
  const Array<double>& X = scene.grid.rest;
  for (size_t p = 0; p < count(); ++p) {
    const auto whole = sum<4>(p, [&](int64_t n, auto& s) {
      for (size_t i = 0; i < 3; ++i) s[i] += scene.mass(n) * X(n, int(i));
      s[3] += scene.mass(n);
    });
    mass_.push_back(whole[3]);
    const auto square = sum<1>(p, [&](int64_t n, auto& s) {
      for (size_t i = 0; i < 3; ++i)
        s[0] += scene.mass(n) * std::pow(X(n, int(i)) - whole[i] / whole[3], 2);
    });
    size_.push_back(2 * std::sqrt(square[0] / mass_[p]));
  }
}

void Pieces::find_pins(const Scene& scene) {
  const Array<double>& X = scene.grid.rest;
  std::vector<double> pinned(count());
  pins_.resize(count());
  for (size_t p = 0; p < count(); ++p) {
    const auto nodes = sum<4>(p, [&](int64_t n, auto& s) {
      if (kinds_[size_t(n)] != kPinnedNode) return;
      for (size_t i = 0; i < 3; ++i) s[i] += X(n, int(i));
      s[3] += 1;
    });
    pins_[p] = {nodes[0], nodes[1], nodes[2]};
    pinned[p] = nodes[3];
  }
  // X_i - sum w_im X_m of dependent nodes, with the weight 1 - sum w_im
  const auto rest = [&](int32_t n) -> Vec3 { return {X(n, 0), X(n, 1), X(n, 2)}; };
  for (int64_t i = 0; i < scene.dependent.count(); ++i) {
    const auto p = size_t(scene.grid.piece(scene.dependent.node(i)));
    const Span<const int32_t> parents = scene.dependent.parents(i);
    const Span<const double> weights = scene.dependent.weights(i);
    pins_[p] = plus(pins_[p], rest(scene.dependent.node(i)));
    pinned[p] += 1;
    for (int64_t m = 0; m < parents.size(); ++m) {
      pins_[p] = minus(pins_[p], scaled(rest(parents.data[m]), weights.data[m]));
      pinned[p] -= weights.data[m];
    }
  }
  for (size_t p = 0; p < count(); ++p)
    for (size_t d = 0; d < 3 && pinned[p] > 0; ++d) pins_[p][d] /= pinned[p];
}

Vec3 Pieces::slide(size_t p, Vec3 velocity) const {
  for (size_t d = 0; d < 3; ++d)
    if (axes_[p] >> d & 1) velocity[d] = 0;
  return velocity;
}

RigidMotion Pieces::rigid_motion(size_t p, const PieceState& state) const {
  if (axes_[p] == 0) {
    RigidMotion motion{state.centre, state.velocity, state.spin, inverse(state.inertia)};
    for (const double value : motion.per_inertia.m)
      if (!std::isfinite(value)) motion.per_inertia = {}, motion.spin = {};
    return motion;
  }
  RigidMotion motion{state.centre, slide(p, state.velocity), {}, {}};
  const int d = std::countr_zero(axes_[p]);
  if (!std::has_single_bit(axes_[p]) || !(state.inertia(d, d) > 0)) return motion;
  motion.spin[size_t(d)] = state.spin[size_t(d)];
  motion.per_inertia(d, d) = 1 / state.inertia(d, d);
  return motion;
}

Vec3 Pieces::turn_about_pins(size_t p, const PieceState& state) const {
  const Vec3 arm = minus(state.centre, pins_[p]);
  PieceState about = state;  // moments of the mass in the centre are added
  about.spin = plus(state.spin, scaled(cross(arm, state.velocity), mass_[p]));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      about.inertia(i, j) +=
          mass_[p] * ((i == j ? dot(arm, arm) : 0) - arm[size_t(i)] * arm[size_t(j)]);
  const RigidMotion motion = rigid_motion(p, about);
  return times(motion.per_inertia, motion.spin);
}

double Pieces::spin_square(size_t p, const PieceState& state) const {
  const RigidMotion motion = rigid_motion(p, state);
  return dot(motion.spin, times(motion.per_inertia, motion.spin));
}

}  // namespace elastogen
