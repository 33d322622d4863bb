// SPDX-License-Identifier: Apache-2.0
// Warnings about pieces of a body that nothing holds.

#pragma once

#include "scene/set_up.hpp"

namespace elastogen {

/// Removes the finding "loose-pieces" if a pin, hold or move holds every piece. Warns by name of
/// pieces that nothing holds and that have no collider below them, if others are held or stand:
/// they fall out of the picture.
void judge_pieces(const Asset& asset, const RunDescription& run, Setup& setup);

}  // namespace elastogen
