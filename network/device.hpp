// SPDX-License-Identifier: Apache-2.0
// What the solver knows of the CUDA device, in builds with and without it.

#pragma once

#include "core/cuda/card.hpp"
#include "core/time_scheme.hpp"
#include "network/quasi_solver.hpp"
#include "network/solver.hpp"

#include <memory>

namespace elastogen {

/// What a step says of its end.
struct Certificate {
  PotentialValue value;
  double size = 0;         ///< |grad Phi|_2 over the free nodes [N]
  bool finite = false;     ///< all of these and the displacement
  bool in_flight = false;  ///< free pieces got the mean motion of their predictor
};

/// Energies that a step has beside the potential [J].
struct MotionEnergy {
  double kinetic = 0, gravity = 0;
};

namespace cuda {

/// The steps of a clip in the modes quasi, newton and paper, with the state and all that they work
/// on in the device's memory. u is the displacement that a step works on, (nodes, 3).
class DeviceStep {
 public:
  virtual ~DeviceStep() = default;

  /// Takes the arrays of a state to step from.
  virtual void upload(const State& state) = 0;
  /// Fills the arrays of a state, or its positions.
  virtual void download(State& state, StateParts parts) = 0;
  /// Whether there is a step before, for BDF2.
  virtual bool has_before() const = 0;

  /// Predictor, inertia, frozen rotations and lagged contact of a step from the state at `time`,
  /// and u where it starts (network/predictor.hpp).
  virtual void begin_step(const StepScheme& scheme, double time) = 0;
  /// Takes the extrapolation of lowest Phi in float for u (Predictor::extrapolate), if Phi is lower
  /// there; the first after begin_step.
  virtual void choose_start() = 0;
  /// Cuts the way to u where colliders are in it; the clear start is u_now, with what colliders run
  /// over carried along.
  /// @return the collider that a point lies in all the same, else null.
  virtual const Collider* clear_start() = 0;
  /// Largest |u - u_now| of a component [m], u_now the displacement at the start of the step.
  virtual double farthest() = 0;
  /// u = u_now.
  virtual void return_to_now() = 0;
  /// u = the clear start; before anything is iterated.
  virtual void return_to_clear_start() = 0;
  /// Whether Phi in float is lower at u than at the clear start; before anything is iterated.
  virtual bool is_below_clear_start() = 0;
  /// Phi in float64 at u and at u_now.
  virtual double phi() = 0;
  virtual double phi_now() = 0;

  /// Nodal rotations of the preconditioner from u.
  virtual void set_nodal_rotations() = 0;
  /// As QuasiSolver<T>::solve on u with a first matrix in float; T is float while |grad Phi| is
  /// above `precise_below`, then double. Up to the target that is float to the end, infinity is
  /// double from the start.
  virtual IterationResult solve(double target, int max_outer, double precise_below,
                                const std::function<bool()>& interrupted) = 0;
  /// u from and to the host; for tests.
  virtual void upload_u(const double* u) = 0;
  virtual void download_u(double* u) = 0;
  /// As NewtonSolver::solve on u.
  virtual IterationResult newton(double target, int max_outer, int max_inner,
                                 const std::function<bool()>& interrupted) = 0;
  /// As PaperSolver::solve on u, in float; of a step that was made for it.
  virtual IterationResult paper(const std::function<bool()>& interrupted) = 0;

  /// Rounds the new positions from u, u to them, and takes the residual there, and the
  /// energies of the motion to them.
  /// @param may_fly  free pieces get the mean motion of their predictor (free_flight.hpp), unless
  ///                 something touches a collider.
  virtual Certificate certify(bool may_fly) = 0;
  /// The positions of the certificate and the velocities to them become the state.
  virtual MotionEnergy finish() = 0;
  /// Largest |x| of a component of the state [m].
  virtual double reach() = 0;

  /// Takes points whose frames are made here from now on; false: there is no room for them beside
  /// what steps take. `start_frame` makes one of the state and sends it to one of two places on
  /// the host beside what comes next, `take_frame` waits for it there, on any thread.
  virtual bool carry(const Embedding& embedding, bool with_gradient) = 0;
  virtual void start_frame(int slot) = 0;
  virtual CarriedFrame take_frame(int slot) const = 0;

  /// The gradient of the last certificate, (nodes, 3).
  virtual void download_gradient(double* gradient) const = 0;
};

/// Of a potential that has the scheme of the run, and must outlive it.
/// @throws Error (resources) where the device has no room for
///         what the scene takes to the end of its clip, with both amounts, (device) in builds
///         without CUDA.
std::unique_ptr<DeviceStep> make_device_step(const PotentialTerms& terms,
                                             const EncoderChoice& encoder);

/// The same for the published algorithm, which has no first matrix.
/// @throws Error as above, and as check_paper_scene.
std::unique_ptr<DeviceStep> make_device_step(const PotentialTerms& terms, const PaperLoops& loops);

}  // namespace cuda
}  // namespace elastogen
