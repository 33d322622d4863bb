// SPDX-License-Identifier: Apache-2.0
// The frames of a clip, from the state to the files: a frame is written on another thread beside
// the steps that lead to the next one.

#pragma once

#include "cli/run.hpp"
#include "cli/stepper.hpp"
#include "io/animation_writer.hpp"
#include "voxelize/embedding.hpp"

#include <future>

namespace elastogen {

class ClipFrames {
 public:
  /// Opens the animations. All arguments but the notes must outlive it.
  /// @param notes  gets what the animations leave out.
  /// @throws Error as AnimationWriter::create and make_picture_writer.
  ClipFrames(const Asset& asset, const Setup& setup, const AnimateOptions& options,
             const RunHooks& hooks, std::vector<std::string>& notes);

  /// Takes the stepper, which must outlive it and has begun.
  void begin(Stepper& stepper);

  /// Whether an animation takes velocities and residual: its frames are written at once.
  bool with_motion() const { return with_motion_; }

  /// Adds the frame of the state that the stepper has reached and waits for the one before; writing
  /// goes on beside what follows, where loops may have several threads.
  /// @param state  up to date where the stepper works on it, or with_motion().
  /// @throws what writing the frame before has thrown.
  void add(const State& state, const FrameCertificate& certificate);

  /// Waits for the last frame. @throws what writing it has thrown.
  void wait();

  /// Makes the files whole, after wait(); adds what the writers have to say.
  void finish(RunReport& report);

  /// Largest component of a displacement in the frames written so far [m], after wait().
  double largest_motion() const { return largest_motion_; }

 private:
  /// Where the stepper leaves the making of frames to this.
  struct Made {
    Array<double> displacement, gradient;
  };

  int64_t make(const State& state);
  void carry(const State& state, Array<double>& displacement) const;
  const State& grid_state(const State& state);
  CarriedFrame made(int64_t number) const;
  void write(int64_t number, AnimationFrame frame);

  const Setup& setup_;
  const AnimateOptions& options_;
  const RunHooks& hooks_;
  std::vector<std::unique_ptr<AnimationWriter>> animations_;
  bool with_motion_ = false, with_gradient_ = false;
  Embedding embedding_;
  Stepper* stepper_ = nullptr;
  bool by_stepper_ = false;  ///< it makes the frames
  Made made_[2];
  int64_t count_ = 0;  ///< of frames made here
  State grid_state_;   ///< used where the state has more nodes than the grid
  double largest_motion_ = 0;
  std::future<void> writing_;  ///< last, so that it ends before what it works on
};

}  // namespace elastogen
