// SPDX-License-Identifier: Apache-2.0
// Pieces of a body that nothing holds.

#pragma once

#include "scene/set_up.hpp"

namespace elastogen {

/// Takes the finding "loose-pieces" back where a pin, hold or move holds each piece. Warns by name
/// of pieces that nothing holds and that have no collider below them where others are held or
/// stand: they fall out of the picture.
void judge_pieces(const Asset& asset, const RunDescription& run, Setup& setup);

}  // namespace elastogen
