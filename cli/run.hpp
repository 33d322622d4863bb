// SPDX-License-Identifier: Apache-2.0
// The main job of the command: runs a scene, prints what is found, and gives the exit code.

#pragma once

#include "cli/exit_code.hpp"
#include "cli/options.hpp"
#include "scene/clip.hpp"
#include "scene/tet_asset.hpp"

#include <functional>
#include <string>

namespace elastogen {

/// Additions of a verb to a run.
struct RunHooks {
  const TetAsset* tets = nullptr;  ///< used in place of the voxelised asset
  std::function<void(const Array<double>& positions)> on_frame;  ///< as ClipHooks
  std::function<void(const StepReport&)> on_step;
  std::function<void(const std::string& text)> on_warning;  ///< instead of standard error
};

struct CommandResult {
  ExitCode code = kExitDone;
  RunReport report;
};

/// Animates an asset that has been read. Output files are complete even if the run ends early.
/// @throws Error for all errors before the first step, and for failing disks.
CommandResult run_animation(const Asset& asset, const AnimateOptions& options, double read_seconds,
                            const RunHooks& hooks = {});

/// "5 of 5 steps solved", and how many of them are within the time error where some are not.
std::string step_counts(const RunReport& report);

}  // namespace elastogen
