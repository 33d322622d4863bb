// SPDX-License-Identifier: Apache-2.0
// Implicit time steps: the next state is a minimum of
//
//     Phi(u) = a0/(2 dt^2) (u - uhat).M (u - uhat) + E(u) - f.u,
//
// implicit Euler and BDF2 with a0 and uhat of core/time_scheme.hpp, gravity within uhat, so that
// with the voxel element and the network's masses the potential is the network's. Newmark 1/4, 1/2:
//
//     a0 = 4,   uhat = u + dt v + (dt^2/4) a,
//     a' = (4/dt^2) (u' - uhat),   v' = v + dt/2 (a + a'),
//
// with gravity within f. Rotations of the torsion correction are those at the start of the step. So
// is the history of materials that yield; it is committed once, for the state that is returned. For
// materials without a potential the step is a root of the same gradient
// (integrators/equilibrium.hpp).

#pragma once

#include "core/time_scheme.hpp"
#include "mpm_fem/integrators/fem_loads.hpp"
#include "mpm_fem/integrators/fem_state.hpp"
#include "mpm_fem/integrators/step_solve.hpp"

namespace elastogen::fem {

class ImplicitFem {
 public:
  /// The scene must outlive the integrator.
  /// @throws Error as StepSolve, and where the scheme of the scene has stages (stage_fem.hpp)
  ///         or is Newmark's and there is damping.
  explicit ImplicitFem(const FemScene& scene, const ImplicitOptions& options = {});

  /// Advances the state by dt. If the result is not finite the state stays as it was and the report
  /// says so. Same bits on every run and any number of threads.
  /// @throws Error unless the arrays of the state are (nodes, 3).
  FemStepReport step(FemState& state);
  /// step() by a part of dt from state.time; the count of steps stays. A step that is made in parts
  /// has no step before it, so that BDF2 begins with implicit Euler.
  FemStepReport step_part(FemState& state, double part);

  const FemScene& scene() const { return scene_; }
  double edge() const { return solve_.terms().length(); }  ///< mean one of an element [m]
  /// Push of each collider on the body at the end of the last step, which led to u [N].
  std::vector<Vec3> pushes(In<double> u) { return terms_.contact.pushes(u); }

  /// Forces that hold the body at the end of the last step [N], (nodes, 3): the gradient of Phi
  /// before it is folded, at fixed components as Potential::held_gradient has it.
  const Array<double>& holding() const { return holding_; }

  /// Loads at the end of the last step [N], (nodes, 3).
  const Array<double>& loads() const { return applied_.force(); }
  /// Gradient of Phi at the last state [N], (nodes, 3), 0 at fixed components.
  const Array<double>& residual() const { return solve_.residual(); }
  const Potential& potential() const { return potential_; }

 private:
  /// Start, end and length of a step [s].
  struct Period {
    double start, end, dt;
  };

  FemStepReport advance(FemState& state, const Period& period);
  StepScheme scheme_of(const FemState& state) const;
  void begin(FemState& state);
  void start_newmark(FemState& state);
  void set_force();
  Array<double> velocities(const Array<double>& u, const FemState& state) const;
  Array<double> minimise(const FemState& state, Array<double>& u, FemStepReport& report);
  void finish(const Array<double>& u, Array<double> handed, FemState& state, FemStepReport& report);

  const FemScene& scene_;
  ImplicitOptions options_;
  StepSolve solve_;
  FemPotential& terms_;   // of the solve
  Potential& potential_;  // of the terms
  Period period_ = {};    // of the present step
  StepScheme scheme_;
  FemLoads applied_;  // at its end
  Array<double> predictor_, holding_;
};

}  // namespace elastogen::fem
