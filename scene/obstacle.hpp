// SPDX-License-Identifier: Apache-2.0
// A rigid obstacle as text, as values, and as a collider when the asset's box is known.

#pragma once

#include "core/collider.hpp"
#include "voxelize/regions.hpp"

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

/// Friction of a sticky collider: a body that touches it moves with it and does not come off.
inline constexpr double kSticks = std::numeric_limits<double>::infinity();

/// A coefficient of friction, or the word sticky. @throws Error (usage) naming the text.
double parse_friction(std::string_view text);

struct Obstacle {
  std::string text;  ///< as it was typed, for messages
  Collider::Shape shape = Collider::Shape::kPlane;
  std::array<Place, 3> point = {};  ///< of the plane; centre of the sphere; lower corner of a box
  std::array<Place, 3> upper = {};  ///< upper corner of the box
  Vec3 normal = {0, 1, 0};          ///< of the plane towards its free side, of length 1
  double radius = 0;                ///< of the sphere [m]
  /// Coulomb's coefficient, or kSticks; unset: the scene's friction.
  std::optional<double> friction = {};
  std::string name = {};  ///< empty: named by its number
  Path path = {};         ///< offsets [m]
};

/// Reads
///
///     plane(PLACE x3, NUMBER x3) | sphere(PLACE x3, LENGTH) | box(PLACE x6: two corners)
///         [friction NUMBER|sticky] [name WORD] [path TIME:x,y,z; TIME:x,y,z ...]
///
/// The plane has a point and a normal of any length towards its free side. Keys of a path are
/// offsets [m] at ascending times. Blanks may stand between all parts; places are lengths or shares
/// of the box.
///
/// @throws Error (usage) naming the text, what is wrong, and the grammar.
Obstacle parse_obstacle(std::string_view text);

/// The collider for an obstacle beside an asset.
/// @param box             of the asset [m]; shares refer to it.
/// @param name, friction  used if the obstacle has none.
/// @throws Error (usage) naming the text if a box has no extent; as check_collider.
Collider place_obstacle(const Obstacle& obstacle, const PlacedBox& box, const std::string& name,
                        double friction);

}  // namespace elastogen
