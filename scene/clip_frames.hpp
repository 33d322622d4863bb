// SPDX-License-Identifier: Apache-2.0
// The frames of a clip, from the stepper to the files: a frame is written on another thread beside
// the steps that lead to the next one.

#pragma once

#include "io/animation_writer.hpp"
#include "scene/clip.hpp"
#include "scene/stepper.hpp"

#include <future>

namespace elastogen {

class ClipFrames {
 public:
  /// Opens the animations. All arguments must outlive it.
  /// @param note  takes what the animations leave out.
  /// @throws Error as AnimationWriter::create and the caller's writers.
  ClipFrames(const Asset& asset, const Setup& setup, const RunDescription& run,
             const ClipHooks& hooks, const std::function<void(std::string)>& note);

  /// Takes the stepper, which must outlive it and has begun.
  void begin(Stepper& stepper);

  /// Whether an animation takes velocities and residual: its frames are written at once.
  bool with_motion() const { return with_motion_; }

  /// Adds the frame of the state that the stepper has reached and waits for the one before; writing
  /// goes on beside what follows, where loops may have several threads.
  /// @throws what writing the frame before has thrown.
  void add(const FrameCertificate& certificate);

  /// Waits for the last frame. @throws what writing it has thrown.
  void wait();

  /// Makes the files whole, after wait(). @param note  takes what the writers have to say.
  /// @return their warnings.
  std::vector<std::string> finish(const std::function<void(std::string)>& note);

  /// Largest component of a displacement in the frames written so far [m], after wait().
  double largest_motion() const { return largest_motion_; }

 private:
  const State& grid_state();
  void write(int64_t number, AnimationFrame frame);

  const Setup& setup_;
  const RunDescription& run_;
  const ClipHooks& hooks_;
  std::vector<std::unique_ptr<AnimationWriter>> animations_;
  bool with_motion_ = false, with_gradient_ = false;
  CarriedPoints points_;
  Stepper* stepper_ = nullptr;
  State grid_state_;  ///< used where the state has more nodes than the grid
  double largest_motion_ = 0;
  std::future<void> writing_;  ///< last, so that it ends before what it works on
};

}  // namespace elastogen
