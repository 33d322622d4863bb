// SPDX-License-Identifier: Apache-2.0
// --collider: a rigid obstacle as text.

#pragma once

#include "core/collider.hpp"
#include "io/asset.hpp"

#include <string>
#include <string_view>

namespace elastogen {

/// Reads
///
///     plane(PLACE x3, NUMBER x3) | sphere(PLACE x3, LENGTH) | box(PLACE x6: two corners)
///         [friction NUMBER] [name WORD] [path TIME:x,y,z; TIME:x,y,z ...]
///
/// a point of the plane and a normal of any length to its free side; path keys are offsets [m] at
/// ascending times. Blanks may stand between all parts; places are lengths or shares of the box.
///
/// @param box       of the asset [m], which shares refer to.
/// @param name, friction  where the text has none.
/// @throws Error (usage) naming the text, what is wrong, and the grammar.
Collider parse_collider(std::string_view text, const PlacedBox& box, const std::string& name,
                        double friction);

/// Reads TIME:x,y,z; TIME:x,y,z ..., as in a collider. @throws Error (usage) saying what is wrong.
std::vector<PathKey> parse_path(std::string_view text);

}  // namespace elastogen
