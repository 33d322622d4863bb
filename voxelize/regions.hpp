// SPDX-License-Identifier: Apache-2.0
// Parts of an asset in the words of the command: places (y<5%, z>0.2m, box(...), sphere(...), all), and what
// the asset names or paints (node:Hat, material:Skin, colour:#ff0000, attr:weight>0.5).

#pragma once

#include "core/voxel_grid.hpp"
#include "io/asset.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace elastogen {

/// A length [m], or a share of the asset's box along an axis, from its lower face.
struct Place {
  double value = 0;
  bool percent = false;  ///< value is a share: 0.05 for 5%

  bool operator==(const Place&) const = default;
};

/// A place: a closed region. Points within 1e-9 of the box's longest edge from its border belong to
/// it, and < means the same as <=, so that it always contains a layer of nodes in its border.
/// Or a part of the asset, which only the asset tells (scene/asset_part.hpp).
struct Selection {
  enum class Kind { kAll, kHalfSpace, kBox, kSphere, kNode, kMaterial, kColour, kAttribute };
  Kind kind = Kind::kAll;
  int axis = 0;                       ///< half space: its normal
  bool below = true;                  ///< half space, attribute: the side
  std::array<Place, 3> lower, upper;  ///< box; half space: lower[axis]; sphere: lower is the centre
  double radius = 0;                  ///< sphere [m]

  std::string name;  ///< of nodes, materials, attributes; * stands for any letters
  std::array<uint8_t, 3> colour = {};  ///< sRGB
  double bound = 0;                    ///< of an attribute
  bool with_bound = false;             ///< attribute: the bound belongs to it

  bool is_place() const { return kind < Kind::kNode; }
  bool operator==(const Selection&) const = default;
};

/// Reads
///
///     all | AXIS (< | <= | > | >=) PLACE | box(PLACE x6: lower, upper corner)
///         | sphere(PLACE x3, LENGTH),       AXIS = x | y | z,  PLACE = LENGTH | NUMBER%
///         | node:NAME | material:NAME | colour:#RRGGBB | attr:NAME (< | <= | > | >=) NUMBER
///
/// with blanks anywhere but between two numbers, and lengths as in io/units.hpp. Names keep their
/// blanks and may have colons.
/// @throws Error naming the mistake and the grammar.
Selection parse_selection(std::string_view text);

/// The selection before a colon and the text behind it. Behind a name this is the first colon that a
/// blank follows, if there is one. @throws Error if there is no colon.
std::pair<std::string_view, std::string_view> split_selection(std::string_view text);

/// A text without its blanks. @throws Error if a blank separates two numbers: "1 0" is not 10.
std::string without_blanks(std::string_view text);

/// The texts between separators, one more than there are separators.
std::vector<std::string_view> split(std::string_view text, char at);

/// A length or a share, "3cm" or "50%". @throws Error naming the text.
Place parse_place(std::string_view text);

/// Coordinate of a place along an axis [m]. @param box  of the asset [m].
double coordinate(const Place& place, int axis, const PlacedBox& box);

/// Whether a place has a point. @param box  of the asset [m].
bool contains(const Selection& selection, const Vec3& point, const PlacedBox& box);

/// 1 for each node of the grid that lies in a place at rest, (nodes, 1).
Array<uint8_t> select_nodes(const VoxelGrid& grid, const Selection& selection,
                            const PlacedBox& box);

/// Axis and position [m] of the plane that bounds a half space, with which a grid can be aligned.
std::optional<std::pair<int, double>> plane(const Selection& selection, const PlacedBox& box);

}  // namespace elastogen
