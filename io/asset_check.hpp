// SPDX-License-Identifier: Apache-2.0
// The gate behind every reader: what a file may not contain, and what it should not.

#pragma once

#include "io/asset.hpp"
#include "io/weld.hpp"

namespace elastogen {

/// Adds to the finding of that id, or begins it with the sentence.
void add_finding(Asset& asset, const std::string& what, int64_t count, const std::string& text);

/// Refuses what cannot be simulated, repairs attributes, adds findings (see docs/formats.md):
/// repairs are non-finite uv, normals and colours, set to 0, (0, 0, 1) and white.
/// Assets of points or splats need no triangle (io/cloud_check.hpp).
/// @throws Error (asset) naming file, mesh and first index: a position that is not finite, a
///         corner out of range, no triangle ("nothing to simulate"), no extent.
void check_asset(Asset& asset);

}  // namespace elastogen
