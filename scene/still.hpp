// SPDX-License-Identifier: Apache-2.0
// Explains why next to nothing moves in a clip.

#pragma once

#include "scene/set_up.hpp"

#include <string>

namespace elastogen {

/// Empty if the motion can be seen: kVisibleMotion (io/animation_writer.hpp) of the longest edge if
/// a GLB is written, a millionth if all outputs are for programs. Else the size of the motion and
/// its likely cause.
/// @param motion  largest component of a displacement [m].
std::string said_of_stillness(const Setup& setup, const RunDescription& run, double motion);

}  // namespace elastogen
