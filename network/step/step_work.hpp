// SPDX-License-Identifier: Apache-2.0
// A machine that makes the steps of a clip: the host (host_step.cpp) or a card (device_step.cu). It
// holds the state, the displacement u that a step works on, (nodes, 3), and all that improves u. What
// is done in which order stands once, in solver_step.cpp.

#pragma once

#include "core/time_error.hpp"
#include "core/time_scheme.hpp"
#include "network/precondition/preconditioner.hpp"
#include "network/solver.hpp"
#include "network/step/iteration.hpp"

#include <memory>
#include <string>

namespace elastogen {

/// The residual of a step at the positions that are written, and what else is found there.
struct Certificate {
  PotentialValue value;
  double size = 0;                       ///< |grad Phi|_2 over the free nodes [N]
  bool finite = false;                   ///< all of these and the displacement
  std::vector<Reaction> reactions = {};  ///< of each holder
};

/// Energies that a step has beside the potential [J].
struct MotionEnergy {
  double kinetic = 0, gravity = 0;
};

class StepWork {
 public:
  virtual ~StepWork() = default;

  /// Name of the card, or "cpu".
  virtual std::string machine() const = 0;

  // the state

  /// Copies a state to step from.
  virtual void upload(const State& state) = 0;
  /// Fills a state, or its positions.
  virtual void download(State& state, StateParts parts) = 0;
  /// upload and download around a step of a state that stays the caller's: the host works on its
  /// arrays in place.
  virtual void borrow(State& state) { upload(state); }
  virtual void give_back(State& state) { download(state, StateParts::kAll); }
  virtual double reach() = 0;  ///< largest |x| of a component [m]

  // where iterations start

  /// Predictor, inertia, frozen rotations and lagged contact of a step from the state at `time`,
  /// and u where it starts (predictor.hpp): start 0 of below.
  virtual void begin_step(const StepScheme& scheme, double time) = 0;
  /// Phi in float at start 0, which is u, and at the extrapolations of order 1 to count - 1
  /// (Predictor::extrapolate), into phi, (count).
  virtual void evaluate_starts(int count, double* phi) = 0;
  virtual void use_start(int start) = 0;  ///< takes one of these for u
  /// Largest |u - u_now| of a component [m], u_now the displacement at the start of the step.
  virtual double farthest() = 0;
  /// Cuts the motion from the clear start to u where colliders are met. The clear start is u_now,
  /// with what colliders run over carried along.
  /// @return the collider that a point lies in all the same, else null.
  virtual const Collider* clear_start() = 0;
  /// Whether that cut, in a stage, the way of a body in flight which is fast enough to bounce.
  virtual bool meets_collider() = 0;
  /// Whether Phi in float is lower at u than at the clear start; before anything is iterated.
  virtual bool is_below_clear_start() = 0;
  /// u = the clear start; before anything is iterated.
  virtual void return_to_clear_start() = 0;
  /// Nodal rotations of the preconditioner from u.
  virtual void set_nodal_rotations() = 0;

  // iterations

  /// quasi_loop on u. Gradients are in float to the end where `precise_below` [N] is at most the
  /// target, in double from the start where it is infinite; between, a card begins in float and
  /// goes on in double where |grad Phi| falls below it, and the host is in double.
  virtual IterationResult quasi(double target, int max_outer, double precise_below,
                                const Interrupted& interrupted) = 0;
  /// newton_loop on u.
  virtual IterationResult newton(double target, int max_outer, int max_inner,
                                 const Interrupted& interrupted) = 0;
  /// paper_loop on u; where the machine was made for it.
  virtual IterationResult paper(const Interrupted& interrupted) = 0;
  /// Phi in float64 at u and at u_now.
  virtual double phi() = 0;
  virtual double phi_now() = 0;
  virtual void return_to_now() = 0;  ///< u = u_now

  // the end
  /// Rounds the new positions from u, u to them, and measures the residual there. Pieces in free
  /// flight get the mean motion of their predictor (free_flight.hpp), unless something touches a
  /// collider or the step is the paper's.
  virtual Certificate certify() = 0;
  /// Takes wind, and of stages the normal forces and normals of friction, from the positions of the
  /// certificate, which has to be made again. False: there is neither.
  virtual bool renew_lags() = 0;
  /// Then gives the next solve wind (core/wind_load.hpp), and a share of the change of friction.
  virtual void relax_lags(double share) = 0;
  // steps of stages (StepScheme::is_stage), where the scene's scheme has some

  /// The least motion that counts in an interval, of all pieces [m]: that at their present speed, or
  /// a share of their size.
  virtual double least_motion(double interval) = 0;
  /// Keeps the positions of the certificate as those of the first stage of a step.
  virtual void keep_stage() = 0;
  /// Velocities of a step whose last stage has its certificate, which finish() takes, and what the
  /// step adds to the time error; null: not asked for.
  virtual StageEnd end_step(const TimeErrorOptions* options) = 0;
  virtual StageData stage_data() { return {}; }  ///< of the last step
  /// The positions of the certificate and the velocities to them become the state.
  virtual MotionEnergy finish() = 0;
  /// The gradient of the last certificate, (nodes, 3).
  virtual void download_gradient(double* gradient) const = 0;

  // u from and to the host, for tests

  virtual void upload_u(const double* u) = 0;
  virtual void download_u(double* u) = 0;

  // frames of a clip (Solver::carry)

  virtual void carry(const Embedding& embedding, bool with_gradient) = 0;
  /// Makes a frame of the state in one of two slots, beside what comes next.
  virtual void start_frame(int slot) = 0;
  /// Waits for it; from any thread.
  virtual CarriedFrame take_frame(int slot) const = 0;
};

/// On the host. The terms have the scheme of the run; the scene must outlive it.
/// @param encoder   null: the published algorithm with `loops`.
/// @param in_float  float has the digits for the scene.
std::unique_ptr<StepWork> make_host_step(PotentialTerms&& terms, const EncoderChoice* encoder,
                                         const PaperLoops& loops, bool in_float);

namespace cuda {

/// On a card. The terms have the scheme of the run and must outlive it.
/// @param encoder  as above.
/// @throws Error (resources) where the card has no memory for what the scene takes to the end of
///         its clip, with both amounts, (device) in builds without CUDA, (usage) as
///         check_paper_scene.
std::unique_ptr<StepWork> make_device_step(const PotentialTerms& terms,
                                           const EncoderChoice* encoder, const PaperLoops& loops);

}  // namespace cuda
}  // namespace elastogen
