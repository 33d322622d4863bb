// SPDX-License-Identifier: Apache-2.0
// A body without a file: a box or a sphere, or in the plane z = 0 a rectangle or a disk.

#pragma once

#include "io/asset.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace elastogen {

struct BodyShape {
  enum class Kind { kBox, kSphere, kRectangle, kDisk };
  Kind kind = Kind::kBox;
  Vec3 lower = {}, upper = {};  ///< corners of a box or a rectangle [m]
  Vec3 centre = {};             ///< of a sphere or disk [m]
  double radius = 0;            ///< [m]

  /// Whether it is a metre thick and does not move across: strains and forces lie in the plane.
  bool in_plane() const { return kind >= Kind::kRectangle; }
  bool is_round() const { return kind == Kind::kSphere || kind == Kind::kDisk; }
  bool contains(const Vec3& x) const;
};

/// "box", "sphere", "rectangle" or "disk".
const char* kind_name(BodyShape::Kind kind);

/// Reads box(x0,y0,z0, x1,y1,z1), sphere(x,y,z, r), rectangle(x0,y0,0, x1,y1,0) or disk(x,y,0, r).
/// @throws Error (usage) naming the text, what is wrong, and the grammar.
BodyShape parse_shape(std::string_view text);

/// The mesh of a shape. A sphere has the vertices of an octahedron with faces divided into 32 x 32.
Asset shape_asset(const BodyShape& shape);

}  // namespace elastogen
