// SPDX-License-Identifier: Apache-2.0
// A clip: the steps of a set-up run, its frames, log and state file, and what the report says of
// them.

#pragma once

#include "core/report.hpp"
#include "io/animation_writer.hpp"
#include "scene/nets.hpp"
#include "scene/set_up.hpp"

#include <functional>
#include <memory>
#include <string>

namespace elastogen {

/// What a caller may add to a clip; each may be empty.
struct ClipHooks {
  std::function<bool()> stop;  ///< polled in steps and between them: true ends the clip
  NetMaker make_net;           ///< as StepperHooks
  /// A writer of its own for an output; null: the library's.
  /// @param note  takes what the writer leaves out.
  std::function<std::unique_ptr<AnimationWriter>(const std::string& path, const Asset& asset,
                                                 const Setup& setup,
                                                 const std::function<void(std::string)>& note)>
      open_writer;
  /// Called with each frame in their order, the first included, maybe on another thread beside
  /// the next step: positions of the carried points [m], (points, 3).
  std::function<void(const Array<double>& positions)> on_frame;
  std::function<void(const StepReport&)> on_step;
  /// Called when a frame has been handed to the writers; the first is not counted.
  std::function<void(int64_t frame, const FrameCertificate&)> on_progress;
  std::function<void(const std::string& text)> on_note;  ///< a note, as soon as it is known
};

/// How a clip ended. Frames before its end are written whole in any case.
enum class ClipEnd {
  kConverged,  ///< every step
  kDraft,      ///< a step missed the tolerance, a voxel is inverted, or max_time was over
  kDiverged,   ///< a step had to be refused
  kStopped     ///< on request
};

/// Steps a run to its last frame and makes its files whole.
/// @param report  with what add_summary fills; gets the rest but for its file.
/// @throws Error (usage, device) for what the run cannot do, before the first step; (resources) for
///         disks that fail.
ClipEnd play_clip(const Asset& asset, const Setup& setup, const RunDescription& run,
                  const ClipHooks& hooks, RunReport& report);

}  // namespace elastogen
