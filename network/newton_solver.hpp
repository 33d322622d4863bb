// SPDX-License-Identifier: Apache-2.0
// The newton mode: projected Hessian, PCG with V-cycle and encoder to an Eisenstat-Walker forcing
// term, line search on the true potential. Gradients are float64, corrections float. Where a
// surface folds Phi has saddles, along which that creeps: there the Hessian as it is, in a trust
// region.

#pragma once

#include "core/pcg.hpp"
#include "network/quasi_solver.hpp"

namespace elastogen {

/// Eisenstat and Walker's second choice with safeguards: how far the linear system of a Newton step
/// is solved, from the present residual, the one before (0: none) and the last choice.
double forcing_term(double residual, double before, double last, double target);

/// Which Hessian a Newton step takes, and how far it may go; by numbers alone, for host and device.
class NewtonRegion {
 public:
  /// Before an iteration: it starts with the true Hessian where the last one needed its region.
  void begin();

  TangentKind tangent() const { return tangent_; }

  /// Newton steps that an iteration may take: those of the projected Hessian, or 4 times as many.
  int most_steps(int projected) const {
    return tangent_ == TangentKind::kTrue ? 4 * projected : projected;
  }

  /// What PCG in units of `unit` begins with.
  PcgScalars scalars(double unit) const {
    return {.radius =
                tangent_ == TangentKind::kTrue ? region_.radius(unit) : PcgScalars::kUnbounded};
  }

  /// Takes how it ended, and what has come of its step. After 20 steps of the projected Hessian, of
  /// which 10 are many, or one that Phi did not fall along, the true one takes over.
  /// @return whether there is a way on.
  bool take_step(const PcgScalars& end, double unit, const StepTaken& step);

  /// Steps of this iteration were bounded by the region.
  bool bounded() const { return bounded_; }

 private:
  TangentKind tangent_ = TangentKind::kProjected;
  TrustRegion region_;
  int steps_ = 0;     // of the projected Hessian
  int failures_ = 0;  // in a row
  bool bounded_ = false;
};

class NewtonSolver {
 public:
  explicit NewtonSolver(IncrementalPotential& potential);

  /// Improves u until |grad Phi|_2 <= target [N]; outer counts Newton steps, inner PCG iterations.
  template <class P>
  IterationResult solve(double* u, double target, int max_outer, int max_inner,
                        Preconditioner<P>& preconditioner,
                        const std::function<bool()>& interrupted);

 private:
  void line_search(double* u, PotentialValue& value);

  IncrementalPotential& potential_;
  int64_t size_;
  std::vector<double> trial_u_, gradient_, trial_gradient_;
  std::vector<float> right_, step_;
  PcgWork<float> work_;
  NewtonRegion region_;
  StepTaken taken_;  // by the line search
};

}  // namespace elastogen
