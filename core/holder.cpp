// SPDX-License-Identifier: Apache-2.0
#include "core/holder.hpp"

namespace elastogen {
namespace {

/// exp([s]x) r (Rodrigues).
Vec3 turned(const Vec3& r, const Vec3& s) {
  const double angle = safe_norm(s);
  if (angle == 0) return r;
  const Vec3 n = scaled(s, 1 / angle);
  return plus(plus(scaled(r, std::cos(angle)), scaled(cross(n, r), std::sin(angle))),
              scaled(n, dot(n, r) * (1 - std::cos(angle))));
}

}  // namespace

Vec3 held_displacement(const Holder& holder, const Vec3& rest, double time) {
  if (!holder.moves()) return {};
  const Vec3 offset = offset_at(holder.path, time);
  if (!holder.turns) return offset;
  const Vec3 arm = minus(rest, holder.centre);
  return minus(turned(arm, offset), arm);
}

HolderRate holder_rate(const Holder& holder, double time) {
  // the axis of a turn is the same at all keys, so that the rate is its angular velocity,
  // and what changes that its angular acceleration
  return {holder.turns, holder.centre, rate_at(holder.path, time),
          acceleration_at(holder.path, time)};
}

Vec3 held_velocity(const Holder& holder, const Vec3& place, double time) {
  return holder_rate(holder, time).velocity(place);
}

std::array<double, 9> held_rotation(const Holder& holder, double time) {
  std::array<double, 9> rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (!holder.turns) return rotation;
  const Vec3 offset = offset_at(holder.path, time);
  for (size_t j = 0; j < 3; ++j) {
    Vec3 axis = {};
    axis[j] = 1;
    const Vec3 column = turned(axis, offset);
    for (size_t i = 0; i < 3; ++i) rotation[3 * i + j] = column[i];
  }
  return rotation;
}

}  // namespace elastogen
