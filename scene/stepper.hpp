// SPDX-License-Identifier: Apache-2.0
// Makes the steps of a run: the network on the CPU or on a card, finite elements, statics,
// particles. A stepper owns all of its state.

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

  /// Starts at rest, plus a rigid motion.
  virtual void begin(const StartMotion& motion) = 0;
  /// Starts from the state of another run at its nodes, as state() returns it.
  virtual void begin_at(const State& state) = 0;
  /// Advances by dt. If the report says that the step was refused or interrupted, the state is the
  /// one before the step.
  virtual StepReport advance() = 0;
  /// The present state of the nodes, of which the first are those of the scene's grid. Valid until
  /// the next call. It is copied from the card if steps run there.
  virtual const State& state() = 0;
  /// Of the last step, where that was made by stages.
  virtual StageData stage_data() const { return {}; }
  /// Whether animations, which are in single precision, can hold the positions.
  virtual bool fits_single() const = 0;

  /// Sets the points that frames move; call after begin. They must outlive the stepper.
  virtual void carry(const CarriedPoints& points, bool with_gradient) = 0;
  /// Makes a frame of the present state. @return its number, from 0.
  virtual int64_t start_frame() = 0;
  /// Waits for one of the last two frames; may be called on another thread. The result is valid
  /// until the second start_frame() after its own.
  virtual CarriedFrame take_frame(int64_t number) const = 0;

  /// Gradient of the incremental potential at the last state [N], (nodes, 3); its first nodes are
  /// those of the grid.
  virtual Span<const double> residual() const = 0;
  /// The strain of particles, valid until the next step; null if there are none.
  virtual const ParticleStrain* particles() { return nullptr; }
  /// Where steps run: "cpu", or the name of a card.
  virtual std::string device() const { return "cpu"; }
  /// Fills the header of a state file.
  virtual void describe(StateHeader& header) const = 0;
  /// The plastic state of its body; none if no material yields.
  virtual std::optional<StatePlastic> plastic() const { return {}; }
  /// Extent of its particles; none without particles.
  virtual std::optional<CloudReport> cloud() const { return {}; }
};

/// The largest position that single precision holds with a margin [m].
inline constexpr double kLargestSingle = 1e37;

/// Requests of a caller beside the description of a run.
struct StepperHooks {
  std::function<bool()> stop = [] { return false; };  ///< polled in steps; true abandons one
  NetMaker make_net;  ///< makes nets that have no file; empty: their laws replace them
};

/// The stepper of a run. Setup and description must outlive it.
/// @param notes  gets a sentence for each material whose law replaces a net.
/// @throws Error (usage) if the scene has something that the stepper cannot do.
std::unique_ptr<Stepper> make_stepper(const Setup& setup, const RunDescription& run,
                                      const StepperHooks& hooks, std::vector<std::string>& notes);

}  // namespace elastogen
