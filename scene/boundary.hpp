// SPDX-License-Identifier: Apache-2.0
// Boundary conditions of parts of a body (held, loaded, moved), as text and as values.

#pragma once

#include "core/collider.hpp"
#include "voxelize/regions.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

/// Nodes that do not move.
struct Pin {
  std::string text;  ///< as it was typed, for messages; so in all these structs
  Selection selection;
};

/// Displacement components that stay 0.
struct Hold {
  std::string text;
  Selection selection;            ///< selects nodes
  std::array<bool, 3> axes = {};  ///< along which they are held
};

/// A dead load.
struct Traction {
  std::string text;
  Selection selection;                  ///< selects the nodes whose faces carry it
  Vec3 force = {};                      ///< total [N]
  std::optional<double> pressure = {};  ///< against the normal of each face [Pa]; replaces force
};

/// A force on all of a part, spread by mass.
struct Force {
  std::string text;
  Selection selection;  ///< selects nodes
  Path force;           ///< [N]; one key: at all times
};

/// A rigid motion along a path.
struct Move {
  std::string text;
  Selection selection;  ///< selects nodes
  bool turns = false;
  Path path;                              ///< offsets [m], or rotation vectors of a turn [rad]
  std::array<Place, 3> turn_centre = {};  ///< a point of the axis
};

/// Reads a selection (voxelize/regions.hpp). @throws Error (usage) as parse_selection.
Pin parse_pin(std::string_view text);

/// Reads 'SELECTION: AXES', AXES being x, y, z or several of them: 'x<1%: x', 'all: yz'.
/// @throws Error (usage) naming the text and what is wrong; so for all parsers here.
Hold parse_hold(std::string_view text);

/// Reads 'SELECTION: x,y,z [UNIT]', a force, or 'SELECTION: p [UNIT]', a pressure.
Traction parse_traction(std::string_view text);

/// Reads
///
///     SELECTION: shift [ease] [loop] TIME:x,y,z; TIME:x,y,z ...
///     SELECTION: turn(PLACE x3, NUMBER x3) [ease] [loop] TIME:ANGLE; TIME:ANGLE ...
///
/// where a turn is right-handed about the axis through a point (three places) along a vector of any
/// length. Times ascend; the path is straight between keys, or slows down at each with `ease`. With
/// `loop` it begins anew after its last key, where it must stand as at the first.
Move parse_move(std::string_view text);

/// Reads 'SELECTION: x,y,z [UNIT]' or 'SELECTION: [ease] [loop] TIME:x,y,z [UNIT]; ...'.
Force parse_force(std::string_view text);

/// Reads a velocity [m/s]: 'x,y,z [UNIT]' or '[ease] [loop] TIME:x,y,z [UNIT]; ...'.
Path parse_wind(std::string_view text);

/// Reads [ease] [loop] TIME:x,y,z; TIME:x,y,z ..., offsets [m].
/// @throws Error (usage) saying what is wrong.
Path parse_path(std::string_view text);

}  // namespace elastogen
