// SPDX-License-Identifier: Apache-2.0
// What is said of a clip in which next to nothing moves, and why that may be.

#pragma once

#include "scene/set_up.hpp"

#include <string>

namespace elastogen {

/// Empty if there is something to be seen: a motion of kVisibleMotion (io/animation_writer.hpp) of
/// the longest edge where a GLB is written, of a millionth where all outputs are for programs.
/// Else the size of the motion and its likely cause.
/// @param motion  largest component of a displacement [m].
std::string said_of_stillness(const Setup& setup, const RunDescription& run, double motion);

}  // namespace elastogen
