// SPDX-License-Identifier: Apache-2.0
// Plays a clip: makes the steps of a set-up run, writes frames, log and state, fills the report.

#pragma once

#include "core/report.hpp"
#include "io/animation_writer.hpp"
#include "scene/nets.hpp"
#include "scene/set_up.hpp"

#include <functional>
#include <memory>
#include <string>

namespace elastogen {

/// Additions of a caller to a clip; each may be empty.
struct ClipHooks {
  std::function<bool()> stop;  ///< polled during and between steps; true ends the clip
  NetMaker make_net;           ///< as StepperHooks
  /// A custom writer for an output; null: the library's writer.
  /// @param note  receives what the writer leaves out.
  std::function<std::unique_ptr<AnimationWriter>(const std::string& path, const Asset& asset,
                                                 const Setup& setup,
                                                 const std::function<void(std::string)>& note)>
      open_writer;
  /// Called with each frame in order, the first included, possibly on another thread during the
  /// next step: positions of the carried points [m], (points, 3).
  std::function<void(const Array<double>& positions)> on_frame;
  std::function<void(const StepReport&)> on_step;
  /// Called when a frame has been passed to the writers; not for the first frame.
  std::function<void(int64_t frame, const FrameCertificate&)> on_progress;
  std::function<void(const std::string& text)> on_note;  ///< a note, as soon as it is known
};

/// How a clip ended. All frames before its end have been written.
enum class ClipEnd {
  kConverged,  ///< every step was solved; frames_over of the report says whether in enough steps
  kDraft,      ///< a step missed the tolerance, a voxel is inverted, or max_time was over
  kDiverged,   ///< a step had to be refused
  kStopped     ///< on request
};

/// Steps a run to its last frame and completes its files.
/// @param report  filled by add_summary; gets everything else but its file.
/// @throws Error (usage, device) before the first step for what the run cannot do; (resources) for
///         disks that fail.
ClipEnd play_clip(const Asset& asset, const Setup& setup, const RunDescription& run,
                  const ClipHooks& hooks, RunReport& report);

}  // namespace elastogen
