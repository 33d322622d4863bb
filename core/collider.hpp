// SPDX-License-Identifier: Apache-2.0
// Rigid obstacles: half space, sphere and box (core/collider_form.hpp), at rest or on a scripted
// path.

#pragma once

#include "core/collider_form.hpp"
#include "core/path.hpp"

#include <string>

namespace elastogen {

struct Collider : ColliderForm {
  std::string name = "floor";  ///< for messages
  double friction = 0.5;       ///< Coulomb's coefficient [-]
  Path path;                   ///< from the place of the description [m]
};

/// A plane at rest: the half space normal . x >= offset is free.
Collider half_space(const Vec3& normal, double offset, double friction);

/// Offset of a collider at a time [m].
inline Vec3 offset_at(const Collider& collider, double time) {
  return offset_at(collider.path, time);
}

/// The core of a collider: the collider without its outermost layer of this depth [m]. A sphere or
/// box thinner than two layers keeps its middle. The layer around the core rounds the edges of a
/// box.
Collider core_of(const Collider& collider, double layer);

/// @throws Error (usage) naming the collider: a normal that is no unit vector, a size or friction
///         that is negative or not finite, times that do not ascend.
void check_collider(const Collider& collider);

}  // namespace elastogen
