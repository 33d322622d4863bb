// SPDX-License-Identifier: Apache-2.0
// Parts of an asset in the words of the command: y<5%, z>0.2m, box(...), sphere(...), all.

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
};

/// A closed region. Points within 1e-9 of the box's longest edge from its border belong to it, and
/// < means the same as <=, so that it always contains a layer of nodes in its border.
struct Selection {
  enum class Kind { kAll, kHalfSpace, kBox, kSphere };
  Kind kind = Kind::kAll;
  int axis = 0;                       ///< half space: its normal
  bool below = true;                  ///< half space: the side
  std::array<Place, 3> lower, upper;  ///< box; half space: lower[axis]; sphere: lower is the centre
  double radius = 0;                  ///< sphere [m]
};

/// Reads
///
///     all | AXIS (< | <= | > | >=) PLACE | box(PLACE x6: lower, upper corner)
///         | sphere(PLACE x3, LENGTH),       AXIS = x | y | z,  PLACE = LENGTH | NUMBER%
///
/// with blanks anywhere but between two numbers, and lengths as in io/units.hpp.
/// @throws Error naming the mistake and the grammar.
Selection parse_selection(std::string_view text);

/// A text without its blanks. @throws Error if a blank separates two numbers: "1 0" is not 10.
std::string without_blanks(std::string_view text);

/// The texts between separators, one more than there are separators.
std::vector<std::string_view> split(std::string_view text, char at);

/// A length or a share, "3cm" or "50%". @throws Error naming the text.
Place parse_place(std::string_view text);

/// Coordinate of a place along an axis [m]. @param box  of the asset [m].
double coordinate(const Place& place, int axis, const PlacedBox& box);

/// @param box  of the asset [m].
bool contains(const Selection& selection, const Vec3& point, const PlacedBox& box);

/// 1 for each node of the grid that lies in a selection at rest, (nodes, 1).
Array<uint8_t> select_nodes(const VoxelGrid& grid, const Selection& selection,
                            const PlacedBox& box);

/// Axis and position [m] of the plane that bounds a half space, with which a grid can be aligned.
std::optional<std::pair<int, double>> plane(const Selection& selection, const PlacedBox& box);

}  // namespace elastogen
