// SPDX-License-Identifier: Apache-2.0
// What holds parts of a body (Scene::holder): at rest, or along a rigid motion.

#pragma once

#include "core/path.hpp"
#include "core/vec3.hpp"

#include <string>

namespace elastogen {

/// With s the offset of the path, a point X of the body at rest is held at
///
///     shift  x = X + s,     turn  x = c + exp([s]x) (X - c).
struct Holder {
  std::string name;    ///< for messages and files: the option as it was typed
  bool turns = false;  ///< the offsets of the path are rotation vectors [rad]
  Vec3 centre = {};    ///< c, a point of a turn's axis [m]
  Path path;           ///< empty: at rest

  bool moves() const { return !path.keys.empty(); }
};

/// How the points of a holder move at one time; shared by host and device.
struct HolderRate {
  bool turns = false;
  Vec3 centre = {};             ///< [m]
  Vec3 rate = {}, change = {};  ///< [m/s] or [rad/s]; of that in a second

  /// Velocity of a point at a place x [m/s].
  ELASTOGEN_HD Vec3 velocity(const Vec3& x) const {
    return turns ? cross(rate, minus(x, centre)) : rate;
  }
  /// Acceleration of a point at a place x [m/s^2].
  ELASTOGEN_HD Vec3 acceleration(const Vec3& x) const {
    if (!turns) return change;
    const Vec3 arm = minus(x, centre);
    return plus(cross(change, arm), cross(rate, cross(rate, arm)));
  }
};

/// What a holder does to the part that it holds: a force [N], and a moment [N m] about a point [m].
struct Reaction {
  Vec3 force = {}, moment = {}, about = {};
};

/// x - X at a time [m].
Vec3 held_displacement(const Holder& holder, const Vec3& rest, double time);
/// The motion of its points, just before a time.
HolderRate holder_rate(const Holder& holder, double time);
/// Velocity of a point at a place x, just before a time [m/s].
Vec3 held_velocity(const Holder& holder, const Vec3& place, double time);
/// exp([s]x) of a turn at a time, row by row; else the identity.
std::array<double, 9> held_rotation(const Holder& holder, double time);

}  // namespace elastogen
