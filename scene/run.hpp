// SPDX-License-Identifier: Apache-2.0
// The main job in one call: from an asset and a description to animation, log, state and report.

#pragma once

#include "scene/clip.hpp"

namespace elastogen {

struct RunResult {
  ClipEnd end = ClipEnd::kConverged;
  RunReport report;
};

/// Reads the input, sets it up, plays the clip and writes the report.
///
///     RunDescription run;
///     run.input = "bunny.obj";
///     run.pins = {parse_pin("y<5%")};
///     run.outputs = {"bunny.glb"};
///     const RunResult result = run_scene(run);
///
/// @throws Error as read_asset, set_up and play_clip.
RunResult run_scene(const RunDescription& run, const ClipHooks& hooks = {});

}  // namespace elastogen
