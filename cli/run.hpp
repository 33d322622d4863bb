// SPDX-License-Identifier: Apache-2.0
// The main job: an asset and options to an animation, with log, state and report.

#pragma once

#include "cli/exit_code.hpp"
#include "cli/options.hpp"
#include "cli/scene_setup.hpp"
#include "io/report_file.hpp"

#include <functional>

namespace elastogen {

/// What a verb may add to a run.
struct RunHooks {
  /// Materials and the one of each voxel; empty: the one of the options everywhere.
  std::vector<Material> materials;
  std::function<Array<int32_t>(const VoxelGrid&)> regions;
  /// The scene in place of the voxelised asset, which is then only its surface.
  std::function<Setup(RunReport&)> set_up;
  /// Called with each frame in their order, the first included, maybe on another thread beside
  /// the next step: positions of the surface [m], (vertices, 3).
  std::function<void(const Array<double>& positions)> on_frame;
  std::function<void(const StepReport&)> on_step;
  std::function<void(const std::string& text)> on_warning;  ///< instead of standard error
};

struct RunResult {
  ExitCode code = kExitDone;
  RunReport report;
};

/// Animates an asset that has been read. Outputs are whole even if the run ends early.
/// @throws Error for everything that is found before the first step, and for disks that fail.
RunResult run_animation(const Asset& asset, const AnimateOptions& options, double read_seconds,
                        const RunHooks& hooks = {});

}  // namespace elastogen
