// SPDX-License-Identifier: Apache-2.0
// What advances the state of a run: the network, or finite elements.

#pragma once

#include "cli/scene_setup.hpp"
#include "io/state_writer.hpp"
#include "network/solver.hpp"

#include <functional>
#include <memory>

namespace elastogen {

class Stepper {
 public:
  virtual ~Stepper() = default;

  /// The rest state with a rigid motion. Its first nodes are those of the scene's grid.
  virtual State start(const StartMotion& motion) const = 0;
  /// Advances by dt, as Solver::step.
  virtual StepReport step(State& state) = 0;
  // for a clip, whose state may stay on a card between the frames
  /// Takes the state to step from.
  virtual void begin(const State&) {}
  /// As step, with arrays that are those of the last read(): its caller reads what it needs.
  virtual StepReport advance(State& state) { return step(state); }
  /// Brings the state up to date.
  virtual void read(State&) const {}
  /// Whether animations, which are in single precision, can hold the positions.
  virtual bool fits_single(const State& state) const;
  /// Takes the points of frames that it makes itself from now on, as Solver's; false: they are made
  /// of the state, which it works on.
  virtual bool carry(const Embedding&, bool /*with_gradient*/) { return false; }
  virtual int64_t start_frame() { return 0; }
  virtual CarriedFrame take_frame(int64_t /*number*/) const { return {}; }
  /// Gradient of the incremental potential [N], (nodes, 3); its first nodes are those of the grid.
  virtual Span<const double> residual() const = 0;
  /// What it runs on: "cpu", or the name of a card.
  virtual std::string device() const { return "cpu"; }
  /// What a state file says of it.
  virtual void describe(StateHeader& header) const = 0;
};

/// The stepper that the options ask for. Setup and options must outlive it.
/// @param interrupted  polled while it steps.
/// @param notes        gets a sentence for each material whose law stands in for a net.
/// @throws Error (usage) where the scene asks for what the stepper cannot do.
std::unique_ptr<Stepper> make_stepper(const Setup& setup, const AnimateOptions& options,
                                      std::function<bool()> interrupted,
                                      std::vector<std::string>& notes);

}  // namespace elastogen
