// SPDX-License-Identifier: Apache-2.0
// Stages of a time step on the host (core/time_stage.hpp): predictor, velocities, momentum, energy
// and time error. Free pieces are referred to their own rigid motion from the start of the step,
// pieces with pins to a turn about these. Nothing but the state goes from a step to the next; what else
// is kept, forces and energy at its ends, may be missing.
//
// Momentum. A scheme conserves linear momentum and loses angular momentum. Both of a free piece are
// set after a step to what the scheme makes of them alone, P* and L*, from the external forces F and
// torques T, of contact and gravity:
//
//     Euler   P* = P0 + h F1,    BDF2   P* = q0 P0 + q1 P_b + k F1,
//     SDIRK2  P* = P0 + (h - k) F_a + k F1,
//     v1 += (P* - P1)/M + dw x (x1 - X1),     dw = I1^-1 (L* - L1).

#pragma once

#include "core/state.hpp"
#include "core/time_error.hpp"
#include "network/potential/incremental_potential.hpp"
#include "network/step/piece_sums.hpp"

#include <functional>
#include <optional>

namespace elastogen {

class HostStages {
 public:
  /// S of time_error.hpp: filtered = S y; both (nodes, 3).
  using Filter = std::function<void(const double* y, double* filtered)>;

  explicit HostStages(IncrementalPotential& potential);

  /// Forgets what is known of another state.
  void forget();
  /// Begins a stage of a step from a state. The second stage of SDIRK2 follows keep_stage().
  void begin(const State& state, const StepScheme& scheme);
  /// xhat - x0 of the stage [m], (nodes, 3).
  const double* motion() const { return motion_.data(); }

  /// Displacements from which iterations may begin, (nodes, 3). 0: the predictor, for free pieces
  /// without the forces of inertia of their turning, which elastic forces balance; 1: e stays
  /// constant; 2: d is a parabola through the other point. There are start_count() of them.
  void start(int order, double* u) const;
  int start_count() const { return scheme_.stage.t_b != 0 ? 3 : 2; }

  /// Keeps the positions that the first stage of SDIRK2 ended with, and the forces there.
  void keep_stage(const double* u);
  /// Velocities at the end of the step, where positions are x and displacements u.
  /// @param energy  of the voxels there [J].
  /// @return false where the energy rises by more than the velocities can make good.
  bool end_step(const Array<double>& x, const double* u, double energy, Array<double>& v);
  /// Whether end_step() took energy from the velocities.
  bool guarded() const { return guarded_; }
  /// Positions that keep_stage() was called with last [m], (nodes, 3).
  const Array<double>& first_stage() const { return x_a_; }
  /// What the step adds to the time error; after end_step().
  TimeError error(const Array<double>& v, const TimeErrorOptions& options, const Filter& filter);
  /// The least of max(T v, 0.04 size) of the pieces in a state [m].
  double least_motion(const State& state, double interval) const;
  /// The step was accepted.
  void accept();

 private:
  /// Contact of the pieces at one time, and its energy.
  struct Forces {
    std::vector<ContactAction> pieces;
    double energy = 0;
    bool known = false;
  };

  Vec3 x0(int64_t n) const { return vector(state_->x, n); }
  Vec3 v0(int64_t n) const { return vector(state_->v, n); }
  static Vec3 vector(const Array<double>& from, int64_t n) {
    return {from(n, 0), from(n, 1), from(n, 2)};
  }
  size_t piece(int64_t n) const { return size_t(scene_.grid.piece(n)); }
  /// e at the start of the step, d and e at the other point.
  Vec3 e0(int64_t n) const { return minus(v0(n), reference_velocity(start_[piece(n)], x0(n))); }
  Vec3 d_b(int64_t n) const;
  Vec3 e_b(int64_t n) const;
  Vec3 e1(int64_t n, const Array<double>& v) const {
    return minus(vector(v, n), reference_velocity(end_[piece(n)], x0(n)));
  }
  void turn_about_pins(size_t piece);
  void set_poses(double t, std::vector<RigidPose>& poses) const;
  Vec3 predicted(int64_t n) const;
  Forces forces(const double* u, const std::vector<PieceState>& pieces);
  PieceState aim(size_t piece, const PieceState& end) const;
  void correct_momentum(const Array<double>& x, Array<double>& v);
  double mechanical_energy(const Array<double>& x, const Array<double>& v) const;
  bool guard(const Array<double>& x, double energy, Array<double>& v);
  Array<double> relative_velocities(const Array<double>& x, const Array<double>& v,
                                    bool rigid) const;
  double take_energy(const Array<double>& D, double rise, Array<double>& v) const;
  bool touched() const;
  double contact_error(size_t piece, const StepWeights& weights, const TimeErrorOptions& options);
  void note_speeds(const Array<double>& v, double share);

  const Scene& scene_;
  IncrementalPotential& potential_;
  Pieces pieces_;
  const State* state_ = nullptr;  // at the start of the step
  StepScheme scheme_;
  std::vector<PieceState> now_, before_, last_;  // at the start, the step before, the end
  std::vector<RigidMotion> motions_;
  std::vector<Vec3> turn_,
      turn_last_;             // of pieces with pins at the start, and a step before [rad/s]
  std::vector<double> gain_;  // of those [rad/s^2]
  double h_last_ = 0;         // of the step before [s], 0: not known
  std::vector<RigidPose> start_, other_, end_;  // of the start, the other point, the stage
  Zeroed<double> motion_, y_, filtered_;
  Array<double> x_a_;  // of the first stage of SDIRK2
  Forces at_start_, at_before_, at_stage_, at_end_;
  double voxels_start_ = 0, voxels_end_ = 0;  // energy of the voxels [J]
  // of the pieces, in this step and as the last one left them
  std::vector<double> speed_, closing_, speed_next_, closing_next_;
  bool moving_colliders_ = false, guarded_ = false;
};

}  // namespace elastogen
