// SPDX-License-Identifier: Apache-2.0
// Implicit Euler and BDF2: predictor, mass factor, velocity, numerical damping.

#pragma once

#include "core/scene.hpp"
#include "core/state.hpp"
#include "core/time_stage.hpp"

#include <cmath>

namespace elastogen {

/// The scheme of one step, or of a stage of it: Phi contains a0/(2 dt^2) m |x - xhat|^2.
struct StepScheme {
  TimeScheme scheme = TimeScheme::kEuler;
  double dt = 0;         ///< [s]
  double a0 = 1;         ///< 1 for Euler, 9/4 for BDF2
  TimeStage stage = {};  ///< where it stands for one (is_stage)
  bool is_stage = false;

  StepScheme() = default;
  StepScheme(TimeScheme s, double step, double factor) : scheme(s), dt(step), a0(factor) {}
  /// Of a stage: dt = k, a0 = 1.
  StepScheme(TimeScheme s, const TimeStage& of) : scheme(s), dt(of.k), stage(of), is_stage(true) {}

  /// Time of its end after the start of the step [s].
  double end() const { return is_stage ? stage.t : dt; }
  /// Velocity at the end that a force gives a mass, over their quotient [s].
  double response() const { return dt / std::sqrt(a0); }
};

/// "euler", "bdf2", "sdirk2", "auto".
const char* scheme_name(TimeScheme scheme);

/// BDF2 where the scene asks for it and there is a step before; else implicit Euler.
StepScheme step_scheme(const Scene& scene, bool has_before);
inline StepScheme step_scheme(const Scene& scene, const State& state) {
  return step_scheme(scene, !state.x_before.empty());
}

/// Predictor xhat of a node's coordinate,
///
///     Euler  x + dt v + dt^2 g,
///     BDF2   (4 x - x') / 3 + (2 dt / 9) (4 v - v') + (4/9) dt^2 g,
///
/// minus x, so that a body far from the origin loses no digits.
ELASTOGEN_HD inline double predicted_motion(const StepScheme& s, double x, double v,
                                            double x_before, double v_before, double gravity) {
  if (s.scheme == TimeScheme::kEuler) return s.dt * (v + s.dt * gravity);
  return (x - x_before) / 3 + 2 * s.dt / 9 * (4 * v - v_before) + 4 * s.dt * s.dt / 9 * gravity;
}

/// Motion of a node's coordinate in a step, without regard to forces: its velocity stays constant
/// (order 1, dt v) or changes as in the step before (order 2; Adams and Bashforth),
///
///     Euler  dt (2 v - v'),     v the mean velocity of a step,
///     BDF2   dt (3 v - v') / 2, v that at its end.
ELASTOGEN_HD inline double extrapolated_motion(const StepScheme& s, int order, double v,
                                               double v_before) {
  if (order == 1) return s.dt * v;
  return s.dt * (s.scheme == TimeScheme::kEuler ? 2 * v - v_before : (3 * v - v_before) / 2);
}

/// Velocity after the step: (x - x^n)/dt or (3 x - 4 x^n + x^{n-1})/(2 dt).
ELASTOGEN_HD inline double velocity_after(const StepScheme& s, double x, double x_now,
                                          double x_before) {
  if (s.scheme == TimeScheme::kEuler) return (x - x_now) / s.dt;
  return (3 * (x - x_now) - (x_now - x_before)) / (2 * s.dt);
}

/// Velocity after a step without forces but gravity, that of the predictor:
///
///     Euler  v + dt g,          BDF2   (4 v - v')/3 + (2/3) dt g.
ELASTOGEN_HD inline double free_velocity(const StepScheme& s, double v, double v_before,
                                         double gravity) {
  if (s.scheme == TimeScheme::kEuler) return v + s.dt * gravity;
  return (4 * v - v_before) / 3 + 2 * s.dt / 3 * gravity;
}

/// Share of its amplitude that a vibration of angular frequency omega keeps over one period.
double amplitude_kept(TimeScheme scheme, double omega_dt);

}  // namespace elastogen
