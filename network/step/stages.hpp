// SPDX-License-Identifier: Apache-2.0
// Stages of a time step on either machine (core/time_stage.hpp): predictor, velocities, momentum, energy
// and time error. Free pieces are referred to their own rigid motion from the start of the step,
// pieces with pins to a turn about these, or to rest where nodes depend on others. Nothing but the
// state goes from a step to the next; what else is kept, forces and energy at its ends, may be missing.
//
// Momentum. A scheme conserves linear momentum and loses angular momentum. Both of a free piece are
// set after a step to what the scheme makes of them alone, P* and L*, from the external forces F and
// torques T, of contact and gravity:
//
//     Euler   P* = P0 + h F1,    BDF2   P* = q0 P0 + q1 P_b + k F1,
//     SDIRK2  P* = P0 + (h - k) F_a + k F1,
//     v1 += (P* - P1)/M + dw x (x1 - X1),     dw = I1^-1 (L* - L1).

#pragma once

#include "core/time_error.hpp"
#include "core/time_scheme.hpp"
#include "network/step/stage_machine.hpp"

#include <functional>

namespace elastogen {

/// Length of a step that stands for none, over dt of the scene: it opens the ledger.
inline constexpr double kNoTime = 1e-9;

/// What the certificate of a stage says of it.
struct StageCertificate {
  double energy = 0;                 ///< of the voxels [J]
  double damping = 0;                ///< power that damping takes [W]
  double moved = 0;                  ///< power of holders that move [W]
  const double* gradient = nullptr;  ///< of Phi [N], (nodes, 3), 0 at pinned nodes
};

class Stages {
 public:
  /// y = S y, S of time_error.hpp; in the memory of the machine, (nodes, 3).
  using Filter = std::function<void(double* y)>;

  /// The machine must outlive it.
  explicit Stages(StageMachine& machine);

  /// Forgets what is known of another state.
  void forget();
  /// Whether that of a time is the state that the last step ended with.
  bool knows(double time) const { return std::abs(time - known_time_) < 1e-6 * scene_.dt; }
  /// Begins a stage of a step from a state. The second stage of SDIRK2 follows keep_stage().
  /// @return xhat - x0 of the stage [m], for predictor and start 0; valid until the stage ends.
  const double* begin(const StateArrays& state, const StepScheme& scheme);

  /// Displacements from which iterations may begin. 0: the predictor, for free pieces without the
  /// forces of inertia of their turning, which elastic forces balance; 1: e stays constant; 2: d is a
  /// parabola through the other point. There are start_count() of them.
  void start(int order, double* u);
  int start_count() const { return at_.stage.t_b != 0 ? 3 : 2; }

  /// Velocities at the end of the present stage, where positions are x.
  void velocities(const double* x, double* v) { machine_.run(TakeVelocities{at_, x, v}); }
  /// Keeps the positions that the first stage of SDIRK2 ended with, and the forces there.
  void keep_stage(const double* u, const StageCertificate& certificate);
  /// Velocities at the end of the step, where positions are x and displacements u.
  /// @return false where the energy rises by more than the velocities can make good.
  bool end_step(const double* x, const double* u, const StageCertificate& certificate, double* v);
  bool guarded() const { return guarded_; }  ///< end_step() took energy from the velocities
  const StepLedger& ledger() const { return ledger_; }  ///< of the step, after end_step()
  /// Whether the ledger waits for the energies at the start of the step.
  bool has_no_ledger() const { return !ledger_before_.known; }
  /// Opens it there; after begin(), while colliders stand as at the start.
  /// @param energy  of the voxels [J].
  void open_ledger(const double* u, double energy);
  /// What the step adds to the time error; after end_step().
  TimeError error(const double* v, const TimeErrorOptions& options, const Filter& filter);
  /// The least of max(T v, 0.04 size) of the pieces at velocities v [m].
  double least_motion(const double* v, double interval);
  /// Whether nothing touched a collider at the start of the step, and a piece is fast enough for a
  /// bounce that counts.
  bool flies_fast() const;
  /// The step was accepted, and ends at a time [s].
  void accept(double time);

 private:
  /// Contact of the pieces at one time, and its energy.
  struct Forces : ActionSums {
    bool known = false;
    std::vector<Vec3> centres;     // of mass, which torques are about [m]
    std::vector<PieceSums> loads;  // LoadForces about the ledger's point; empty: none
  };

  void take_poses();
  void turn_about_pins(size_t piece);
  RigidPose pose(size_t piece, double t) const;
  std::vector<PieceMotion> means(const double* x, const double* v);
  std::vector<PieceState> states(const double* x, const double* v);
  Forces forces(const double* u, const double* x, std::vector<Vec3> centres);
  TwoMomenta load_on(const Forces& f, size_t piece, const Vec3& about) const;
  PieceState aim(size_t piece, const PieceState& end) const;
  void correct_momentum(const double* x, double* v);
  bool guard(const double* x, double energy, double* v);
  void relative_velocities(const double* x, const double* v, bool rigid);
  double take_energy(double rise, double* v);
  bool touched() const;
  bool touched(size_t piece) const;
  ContactError contact_error_of(size_t piece, const StepWeights& weights,
                                const TimeErrorOptions& options) const;
  TimeError worst_error(const StepWeights& weights, const TimeErrorOptions& options);
  void note_speeds(const double* v, double share);
  // stage_ledger.cpp
  BodyAccount account_of(const double* x, const double* v);
  BodyActions actions(const double* x, const Forces& contact, const StageCertificate& certificate);
  TwoMomenta gain_of_references();

  StageMachine& machine_;
  const Scene& scene_;
  const Pieces& pieces_;
  StageNodes at_;
  std::vector<PieceState> now_, before_, last_;  // at the start, the step before, the end
  std::vector<RigidMotion> motions_;
  std::vector<Vec3> turn_,
      turn_last_;             // of pieces with pins at the start, and a step before [rad/s]
  std::vector<double> gain_;  // of those [rad/s^2]
  double h_last_ = 0;         // of the step before [s], 0: not known
  double known_time_ = -1e300;
  std::vector<PiecePoses> poses_;
  Forces at_start_, at_before_, at_stage_, at_end_;
  double voxels_start_ = 0, voxels_end_ = 0;  // energy of the voxels [J]
  // of the pieces, in this step and as the last one left them
  std::vector<double> speed_, spin_, closing_, speed_next_, spin_next_, closing_next_;
  std::vector<Vec3> struck_, struck_next_;  // change of velocity while it touches, of late [m/s]
  bool holders_move_ = false;
  bool is_driven_ = false;  // colliders or holders move, or loads act: the energy may rise
  bool guarded_ = false;
  // of the ledger
  StepLedger ledger_, ledger_before_;  // of the step, and of that before
  StepBooking booking_;                // of the step
};

}  // namespace elastogen
