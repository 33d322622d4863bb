// SPDX-License-Identifier: Apache-2.0
// How the newton mode chooses its linear systems: how far they are solved, which Hessian they have,
// how long their steps may be. By numbers alone, for host and card.

#pragma once

#include "core/trust_region.hpp"
#include "network/potential/local_model.hpp"

namespace elastogen {

/// Eisenstat and Walker's second choice with safeguards: how far the linear system of a Newton step
/// is solved, from the present residual, the one before (0: none) and the last choice.
double forcing_term(double residual, double before, double last, double target);

/// Which Hessian a Newton step takes, and how far it may go.
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

  /// Takes note of how PCG ended and what its step has brought. After 20 steps of the projected
  /// Hessian, of which 10 are many, or one that Phi did not fall along, the true one takes over.
  /// @return whether another step may help.
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

}  // namespace elastogen
