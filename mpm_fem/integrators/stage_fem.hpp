// SPDX-License-Identifier: Apache-2.0
// Time steps of stages (docs/physics.md, section 5a): each stage is a minimum of
//
//     Phi(u) = (u - uhat).M (u - uhat)/(2 k^2) + E(u) - f.u
//
// with uhat relative to the rigid motion of each piece (stage_motion.hpp). Scheme::kSdirk2 makes
// fixed steps of two stages, Scheme::kAuto steps that follow their time error (core/time_error.hpp,
// core/time_control.hpp). Friction of colliders is a bond (contact/bond_friction.cpp).
//
// Momentum. Linear and angular momentum of pieces without prescribed components are set after a
// step to what the scheme makes of them alone, from the external forces F and torques T of contact,
// loads and gravity, with the mass matrix M (stage_balance.cpp):
//
//     Euler   P* = P0 + h F1,      BDF2   P* = q0 P0 + q1 P_b + k F1,
//     SDIRK2  P* = P0 + (h - k) F_a + k F1.

#pragma once

#include "mpm_fem/integrators/fem_loads.hpp"
#include "mpm_fem/integrators/stage_motion.hpp"
#include "mpm_fem/integrators/step_solve.hpp"

#include <functional>

namespace elastogen::fem {

struct StageOptions {
  ImplicitOptions solve = {};
  double time_error = 5e-3;  ///< of kAuto, share of the motion in dt
  /// Stages of kAuto are solved to what their time error needs, where that is more than the
  /// tolerance.
  bool follows_time_error = true;
};

class StageFem {
 public:
  /// The scene must outlive the integrator.
  /// @throws Error as StepSolve and FemPieces, where the scheme of the scene has no stages, and
  ///         where a material yields: the history of a rejected step cannot be taken back.
  explicit StageFem(const FemScene& scene, const StageOptions& options = {});

  /// Advances the state by dt or, with kAuto and at breaks of the paths of colliders, by a step
  /// within dt, of which the report tells the length and whether dt is complete. If it has no
  /// finite result, or `stop`, polled before each trial, returns true, the state stays as it was.
  /// Same bits on every run and any number of threads.
  /// @throws Error unless the arrays of the state are (nodes, 3).
  FemStepReport step(
      FemState& state, const std::function<bool()>& stop = [] { return false; });

  /// As ImplicitFem::holding(); of the last stage.
  const Array<double>& holding() const { return holding_; }

  /// Gradient of Phi at the last state [N], (nodes, 3), 0 at fixed components.
  const Array<double>& residual() const { return solve_.residual(); }
  const Potential& potential() const { return potential_; }
  /// Loads at the end of the last step [N], (nodes, 3).
  const Array<double>& loads() const { return applied_.force(); }
  /// Displacements at the end of the first stage of the last step of SDIRK2 [m], and loads there [N],
  /// (nodes, 3).
  const Array<double>& first_stage() const { return first_; }
  const Array<double>& first_loads() const { return first_loads_; }

 private:
  // stage_fem.cpp: the order of a step
  double interval_end() const;
  TimeScheme kind_of(double h) const;
  double tolerance_of(const TimeStage& stage, double h) const;
  void begin_stage(const TimeStage& stage);
  bool make_stage(const TimeStage& stage, FemStepReport& report);
  bool meets_collider(const Array<double>& predicted);
  bool renew_lags();
  void minimise(double tolerance, Array<double>& u, FemStepReport& report);
  bool make_step(TimeScheme kind, double h, FemStepReport& report);
  bool judge(FemStepReport& report);
  void complete(double end, FemState& state, FemStepReport& report);

  // stage_ledger.cpp: what changes momentum and energy of the whole body
  void open_ledger();
  BodyAccount account_of(const Array<double>& u, const Array<double>& v) const;
  BodyActions actions(const Array<double>& v, const Loads& loads);
  void write_ledger(FemStepReport& report);

  // stage_balance.cpp: momentum and energy
  Loads actions_at(const Array<double>& u);
  PieceMotion aim(size_t piece, const PieceMotion& end) const;
  void correct_momentum();
  bool touched(size_t piece) const;
  bool touched() const;
  double take_energy(const Array<double>& D, double rise);
  bool guard(double elastic_energy);

  // stage_error.cpp: the time error
  double spin_speed(size_t piece, const PieceMotion& motion) const;
  void remember_speeds(double share);
  double least_motion() const;
  ContactError contact_error_of(size_t piece, const StepWeights& weights) const;
  TimeError worst(const Array<double>& y, const StepWeights& weights) const;
  Array<double> filtered(const Array<double>& y);
  TimeError error();

  const FemScene& scene_;
  StageOptions options_;
  StepSolve solve_;
  FemPotential& terms_;   // of the solve
  Potential& potential_;  // of the terms
  FemPieces pieces_;
  StageMotion motion_;
  bool is_driven_;  // something beside gravity does work on the body

  // of the present trial
  const FemState* now_ = nullptr;  // where it starts
  TimeControl control_;
  bool meets_collider_ = false;      // the last stage was not begun for it
  FemLoads applied_;                 // at the end of the stage
  Array<double> u_, v_;              // end of the last stage, velocities at the end of the step
  Array<double> holding_;            // forces at the end of the step
  Array<double> first_;              // end of the first stage of SDIRK2
  Array<double> first_loads_;        // there
  bool guarded_ = false;             // energy was taken from the velocities
  std::vector<PieceMotion> end_;     // the pieces there before velocities are corrected
  Loads at_stage_, at_end_;          // of the first stage of SDIRK2; of the step
  std::vector<PieceMemory> memory_;  // at the end
  StepLedger ledger_before_;         // of the step before
  StepBooking booking_;
};

}  // namespace elastogen::fem
