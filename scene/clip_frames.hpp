// SPDX-License-Identifier: Apache-2.0
// The frames of a clip, from the stepper to the files. A frame is written on another thread while
// the steps to the next one are made.

#pragma once

#include "io/animation_writer.hpp"
#include "scene/clip.hpp"
#include "scene/stepper.hpp"

#include <future>

namespace elastogen {

class ClipFrames {
 public:
  /// Opens the animations. All arguments must outlive it.
  /// @param note  receives what the animations leave out.
  /// @throws Error as AnimationWriter::create and the caller's writers.
  ClipFrames(const Asset& asset, const Setup& setup, const RunDescription& run,
             const ClipHooks& hooks, const std::function<void(std::string)>& note);

  /// Connects the stepper, which must have begun and must outlive this.
  void begin(Stepper& stepper);

  /// Whether an animation needs velocities and residual. Its frames are then written at once.
  bool with_motion() const { return with_motion_; }

  /// Adds the frame of the stepper's state and waits for the frame before. With several threads,
  /// writing continues after the return.
  /// @throws what writing the frame before has thrown.
  void add(const FrameCertificate& certificate);

  /// Waits for the last frame. @throws what writing it has thrown.
  void wait();

  /// Completes the files; call after wait(). @param note  receives the notes of the writers.
  /// @return their warnings.
  std::vector<std::string> finish(const std::function<void(std::string)>& note);

  /// The points that frames move.
  const CarriedPoints& points() const { return points_; }

  /// Largest component of a displacement in the frames written so far [m], after wait().
  double largest_motion() const { return largest_motion_; }

 private:
  const State& grid_state();
  void write(int64_t number, AnimationFrame frame);
  double path_time(int64_t number) const;
  CarriedFrame with_moved(const CarriedFrame& carried, double time);

  const Setup& setup_;
  const RunDescription& run_;
  const ClipHooks& hooks_;
  std::vector<std::unique_ptr<AnimationWriter>> animations_;
  bool with_motion_ = false, with_gradient_ = false;
  CarriedPoints points_;
  Stepper* stepper_ = nullptr;
  State grid_state_;                       ///< used if the state has more nodes than the grid
  Array<double> displacement_, gradient_;  ///< by with_moved
  double largest_motion_ = 0;
  std::future<void> writing_;  ///< last member, so that it ends before the members that it uses
};

}  // namespace elastogen
