// SPDX-License-Identifier: Apache-2.0
// The ledger of steps that are made by stages (docs/physics.md, 5c): momentum and energy of the whole
// body, and what changed them. Impulses and works of a step are integrated as the step integrates its
// velocities; with X a force or a power at a stage (core/time_stage.hpp)
//
//     Euler    J1 = J0 + h X1,                  BDF2   J1 = q0 J0 + q1 J_b + k X1,
//     SDIRK2   J1 = J0 + (h - k) X_a + k X1.

#pragma once

#include "core/time_stage.hpp"
#include "core/vec3.hpp"

namespace elastogen {

/// Momentum [kg m/s] and angular momentum about a fixed point [kg m^2/s]; or a force [N] and its torque
/// about that [N m].
struct TwoMomenta {
  Vec3 linear = {}, angular = {};

  void add(const TwoMomenta& o, double weight);
};

/// Forces and powers at a stage [N], [W]; or their impulses and works in a step [N s], [J].
struct BodyActions {
  TwoMomenta gravity, contact, pins, loads;
  double colliders = 0;  ///< of colliders that move: their forces times their velocities
  double moved = 0;      ///< of pins that move
  double loaded = 0;     ///< of loads
  double rubbed = 0;     ///< against friction, what bonds take up of that included
  double damped = 0;     ///< that damping takes
  double residual = 0;   ///< of the forces that the solver left, r.v

  void add(const BodyActions& o, double weight);
};

/// Energies of the body [J]. At the end of a step contact is the barrier of normal forces, and bonds is
/// what the springs of friction hold.
struct BodyEnergies {
  double kinetic = 0, elastic = 0, gravity = 0, contact = 0, bonds = 0;

  double total() const { return kinetic + elastic + gravity + contact + bonds; }
};

/// A body at one time; elastic energy has that of the hourglass terms in it.
struct BodyAccount {
  TwoMomenta momentum;
  BodyEnergies energy;
};

/// A step, or several of them one after the other.
struct StepLedger {
  bool known = false;
  bool opens = false;  ///< the start of a run: all but its end is empty
  Vec3 about = {};     ///< the point of angular momenta: the centre of mass at the start [m]
  BodyAccount start, end;
  BodyActions done;
  TwoMomenta guarded;     ///< change of momentum by the guard of energy
  double guard = 0;       ///< energy that it took [J]
  double correction = 0;  ///< that the correction of momentum brought [J]

  /// Momentum that no impulse accounts for.
  TwoMomenta gap() const;
  /// Energy that friction took: the work against it but for what bonds hold of that.
  double friction() const { return done.rubbed - (end.energy.bonds - start.energy.bonds); }
  /// Work from outside, without gravity.
  double work() const { return done.colliders + done.moved + done.loaded; }
  /// Energy that the time scheme lost: what is left when all else is accounted for.
  double numerical() const {
    return start.energy.total() - end.energy.total() + work() - done.damped - friction() - guard;
  }
};

/// What the end of a step adds to its ledger.
struct StepBooking {
  BodyActions at_first;     ///< at the first stage of SDIRK2
  BodyActions at_end;       ///< at the last stage
  TwoMomenta of_reference;  ///< of pins: what their reference brings beyond its integral by stages
  double kinetic = 0;       ///< energy of the velocities that the scheme gives [J]
  BodyAccount corrected,
      end;  ///< before and after the guard of energy, the same where it did nothing
};

/// The ledger of a step.
/// @param before  that of the step before, or one that opens
/// @param last    the stage that the step ends with
StepLedger step_ledger(const StepLedger& before, const TimeStage& last, const StepBooking& booking);

/// That of a run.
struct Ledger {
  StepLedger sum;
  int64_t steps = 0;
  double kinetic = 0;      ///< the largest kinetic energy [J]
  double linear = 0;       ///< the largest momentum
  double angular = 0;      ///< the largest angular momentum
  double linear_gap = 0;   ///< the largest gap of a step in momentum
  double angular_gap = 0;  ///< and in angular momentum
  double rise = 0;         ///< the largest rise of energy, over any time, beyond work [J]

  /// Adds the next step; one without a ledger changes nothing.
  void add(const StepLedger& step);

 private:
  double lost_ = 0, most_lost_ = 0;  // energy [J]
};

}  // namespace elastogen
