// SPDX-License-Identifier: Apache-2.0
// Rigid obstacles: half space, sphere and box (core/collider_form.hpp), at rest or on a scripted
// straight path.

#pragma once

#include "core/collider_form.hpp"

#include <string>
#include <vector>

namespace elastogen {

/// Position of a collider on its path; straight and uniform between keys, at rest before the first
/// and after the last.
struct PathKey {
  double time = 0;   ///< [s], ascending
  Vec3 offset = {};  ///< from the place at time 0 of the description [m]
};

struct Collider : ColliderForm {
  std::string name = "floor";  ///< for messages
  double friction = 0.5;       ///< Coulomb's coefficient [-]
  std::vector<PathKey> path;   ///< empty: at rest
};

/// A plane at rest: the half space normal . x >= offset is free.
Collider half_space(const Vec3& normal, double offset, double friction);

/// Offset of a collider at a time [m].
Vec3 offset_at(const Collider& collider, double time);

/// The core of a collider: the collider without its outermost layer of this depth [m]. A sphere or
/// box thinner than two layers keeps its middle. The layer around the core rounds the edges of a
/// box.
Collider core_of(const Collider& collider, double layer);

/// @throws Error (usage) naming the collider: a normal that is no unit vector, a size or friction
///         that is negative or not finite, times that do not ascend.
void check_collider(const Collider& collider);

}  // namespace elastogen
