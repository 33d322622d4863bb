// SPDX-License-Identifier: Apache-2.0
// --hold, --traction and --move: what finite elements alone are told of a part of the body.

#pragma once

#include "cli/options.hpp"
#include "core/collider.hpp"
#include "voxelize/regions.hpp"

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace elastogen {

/// Displacements that stay 0.
struct HoldOption {
  Selection selection;            ///< of nodes
  std::array<bool, 3> axes = {};  ///< along which they are held
};

/// A dead load.
struct TractionOption {
  Selection selection;                  ///< of nodes whose faces carry it
  Vec3 force = {};                      ///< in all [N]
  std::optional<double> pressure = {};  ///< on each face against its normal [Pa], in place of force
};

/// A rigid motion, straight and uniform between keys, at rest before the first and after the last.
struct MoveOption {
  Selection selection;  ///< of nodes
  bool turns = false;
  std::vector<PathKey> path;              ///< offsets [m]; of a turn rotation vectors [rad]
  std::array<Place, 3> turn_centre = {};  ///< a point of the axis
};

/// Reads 'SELECTION: AXES', AXES being x, y, z or several of them: 'x<1%: x', 'all: yz'.
/// @throws Error (usage) naming the text and what is wrong; so do the others.
HoldOption parse_hold(std::string_view text);

/// Reads 'SELECTION: x,y,z [UNIT]', a force, or 'SELECTION: p [UNIT]', a pressure.
TractionOption parse_traction(std::string_view text);

/// Reads
///
///     SELECTION: shift TIME:x,y,z; TIME:x,y,z ...
///     SELECTION: turn(PLACE x3, NUMBER x3) TIME:ANGLE; TIME:ANGLE ...
///
/// a turn by the right hand about the axis through a point (three places) along a vector of any
/// length; times ascend.
MoveOption parse_move(std::string_view text);

/// @param verb  that steps with the network.
/// @throws Error (usage) naming the first option of these that is given.
void check_no_boundary(const AnimateOptions& options, std::string_view verb);

}  // namespace elastogen
