// SPDX-License-Identifier: Apache-2.0
// Rigid obstacles: half space, sphere and box, at rest or on a scripted straight path.

#pragma once

#include "core/base.hpp"

#include <string>
#include <vector>

namespace elastogen {

/// Place of a collider on its path; straight and uniform between keys, at rest before the first and
/// after the last.
struct PathKey {
  double time = 0;   ///< [s], ascending
  Vec3 offset = {};  ///< from the place at time 0 of the description [m]
};

/// What a point sees of a collider: distance to its surface, negative inside, and the unit normal
/// that points out of it.
struct Proximity {
  double distance = 0;  ///< [m]
  Vec3 normal = {};
};

struct Collider {
  enum class Shape { kPlane, kSphere, kBox };
  std::string name = "floor";  ///< for messages
  Shape shape = Shape::kPlane;
  Vec3 centre = {};           ///< plane: a point of it; sphere, box: the centre [m]
  Vec3 normal = {0, 1, 0};    ///< plane: unit vector to the free side
  double radius = 0;          ///< sphere [m]
  Vec3 half = {};             ///< box: half its edges, parallel to the axes [m]
  double friction = 0.5;      ///< Coulomb's coefficient [-]
  std::vector<PathKey> path;  ///< empty: at rest
};

/// A plane at rest: the half space normal . x >= offset is free.
Collider half_space(const Vec3& normal, double offset, double friction);

/// Offset of a collider at a time [m].
Vec3 offset_at(const Collider& collider, double time);

/// Distance and normal of a point, for a collider moved by `offset`.
Proximity proximity(const Collider& collider, const Vec3& offset, const Vec3& point);

/// What is left of a collider below a layer of this depth [m]; a sphere or box of less than two
/// layers keeps its middle. The layer about it rounds the edges of a box.
Collider core_of(const Collider& collider, double layer);

/// Largest share, at most 1, of the straight way from a to b that leaves a point outside a collider
/// a tenth of its distance all along, and no less than `least` [m] where it has that at a; a little
/// less where the way ends at the edge of a box.
double free_share(const Collider& collider, const Vec3& offset, const Vec3& a, const Vec3& b,
                  double least);

/// @throws Error (usage) naming the collider: a normal that is no unit vector, a size or friction
///         that is negative or not finite, times that do not ascend.
void check_collider(const Collider& collider);

}  // namespace elastogen
