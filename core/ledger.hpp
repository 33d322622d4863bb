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

#include <algorithm>

namespace elastogen {

/// Momentum [kg m/s] and angular momentum about a fixed point [kg m^2/s]; or a force [N] and its torque
/// about that [N m].
struct TwoMomenta {
  Vec3 linear = {}, angular = {};

  void add(const TwoMomenta& o, double weight) {
    linear = plus(linear, scaled(o.linear, weight));
    angular = plus(angular, scaled(o.angular, weight));
  }
};

/// Forces and powers at a stage [N], [W]; or their impulses and works in a step [N s], [J].
struct BodyActions {
  TwoMomenta gravity, contact, pins, loads;
  double colliders = 0;  ///< of colliders that move: their forces times their velocities
  double moved = 0;      ///< of pins that move
  double loaded = 0;     ///< of loads
  double rubbed = 0;     ///< of sliding against friction: what heats or strains the bonds
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

/// A body at one time.
struct BodyAccount {
  TwoMomenta momentum;
  BodyEnergies energy;
};

/// A step, or several of them one after the other.
struct StepLedger {
  bool known = false;
  Vec3 about = {};         ///< the point of angular momenta: the centre of mass at the start [m]
  BodyAccount start, end;  ///< elastic with hourglass
  BodyActions done;
  TwoMomenta guarded;     ///< change of momentum by the guard of energy
  double guard = 0;       ///< energy that it took [J]
  double correction = 0;  ///< that the correction of momentum brought [J]

  /// Momentum that no impulse accounts for.
  TwoMomenta gap() const;
  /// Energy that friction took.
  double friction() const { return done.rubbed - (end.energy.bonds - start.energy.bonds); }
  /// Work from outside, without gravity.
  double work() const { return done.colliders + done.moved + done.loaded; }
  /// Energy that the time scheme lost: what is left when all else is accounted for.
  double numerical() const {
    return start.energy.total() - end.energy.total() + work() - done.damped - friction() - guard;
  }
  /// Of that, with the opposite sign: what the solver's residual and the correction of momentum brought.
  double unaccounted() const { return done.residual + correction; }
};

/// That of a run.
struct Ledger {
  StepLedger sum;
  int64_t steps = 0;
  double largest_kinetic = 0;           ///< at the end of a step, or at the start [J]
  double largest_linear = 0;            ///< momentum
  double largest_angular = 0;           ///< angular momentum
  double largest_gap_of_a_step = 0;     ///< momentum
  double largest_angular_gap = 0;       ///< angular momentum, of a step
  double largest_rise = 0;              ///< of energy, beyond works, over any time [J]

  /// Adds the next step; one without a ledger changes nothing.
  void add(const StepLedger& step);

 private:
  double lost_ = 0, most_lost_ = 0;  // energy [J]
};

/// The integral over a step from the powers or forces at its stages.
/// @param at_first  of the first stage of SDIRK2
/// @param at_end    of the last stage
/// @param before    the integral over the step before, for BDF2
BodyActions done_in_step(const TimeStage& last, const BodyActions& at_first,
                         const BodyActions& at_end, const BodyActions& before);

}  // namespace elastogen
