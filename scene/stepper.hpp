// SPDX-License-Identifier: Apache-2.0
// What takes the steps of a run: the network on the CPU or on a card, finite elements, statics. A
// stepper owns all of its state.

#pragma once

#include "io/state_writer.hpp"
#include "io/step_log.hpp"
#include "scene/carried_points.hpp"
#include "scene/nets.hpp"
#include "scene/set_up.hpp"

#include <functional>
#include <memory>
#include <optional>

namespace elastogen {

class Stepper {
 public:
  virtual ~Stepper() = default;

  /// Takes the rest state with a rigid motion.
  virtual void begin(const StartMotion& motion) = 0;
  /// Takes the state of another run at its nodes, as state() gives it.
  virtual void begin_at(const State& state) = 0;
  /// Advances by dt. Where the report says that the step was refused or interrupted the state is
  /// the one before.
  virtual StepReport advance() = 0;
  /// The present state of the nodes, of which the first are those of the scene's grid; valid until
  /// the next call. Where steps run on a card it is brought from there.
  virtual const State& state() = 0;
  /// Whether animations, which are in single precision, can hold the positions.
  virtual bool fits_single() const = 0;

  /// Takes the points that frames move, after begin. They must outlive the stepper.
  virtual void carry(const CarriedPoints& points, bool with_gradient) = 0;
  /// Makes a frame of the present state. @return its number, from 0.
  virtual int64_t start_frame() = 0;
  /// Waits for one of the last two frames; may be called on another thread. What it gives is valid
  /// until the second start_frame() after its own.
  virtual CarriedFrame take_frame(int64_t number) const = 0;

  /// Gradient of the incremental potential at the last state [N], (nodes, 3); its first nodes are
  /// those of the grid.
  virtual Span<const double> residual() const = 0;
  /// The strain of particles, valid until the next step; null where there are none.
  virtual const ParticleStrain* particles() { return nullptr; }
  /// What it runs on: "cpu", or the name of a card.
  virtual std::string device() const { return "cpu"; }
  /// What a state file says of it.
  virtual void describe(StateHeader& header) const = 0;
  /// What its body remembers of its flow; none where no material yields.
  virtual std::optional<StatePlastic> plastic() const { return {}; }
  /// Where its particles are; none of others.
  virtual std::optional<CloudReport> cloud() const { return {}; }
};

/// The largest position that single precision holds with room to spare [m].
inline constexpr double kLargestSingle = 1e37;

/// What a run asks for beside its description.
struct StepperHooks {
  std::function<bool()> stop = [] { return false; };  ///< polled in steps; true gives one up
  NetMaker make_net;  ///< makes nets that no file has; empty: their laws stand in for them
};

/// The stepper of a run. Setup and description must outlive it.
/// @param notes  gets a sentence for each material whose law stands in for a net.
/// @throws Error (usage) where the scene asks for what the stepper cannot do.
std::unique_ptr<Stepper> make_stepper(const Setup& setup, const RunDescription& run,
                                      const StepperHooks& hooks, std::vector<std::string>& notes);

}  // namespace elastogen
