// SPDX-License-Identifier: Apache-2.0
// How the newton mode chooses its linear systems: how far they are solved and how long their steps
// may be, and when folds are looked for. By numbers alone, for host and card.

#pragma once

#include "core/trust_region.hpp"

namespace elastogen {

/// Eisenstat and Walker's second choice with safeguards: how far the linear system of a Newton step
/// is solved, from the present residual, the one before (0: none) and the last choice.
double forcing_term(double residual, double before, double last, double target);

/// How far a Newton step may go: Phi need not be convex, and its Hessian is taken as it is.
class NewtonRegion {
 public:
  /// Before an iteration.
  void begin() { *this = {}; }

  /// What PCG in units of `unit` begins with.
  PcgScalars scalars(double unit) const { return {.radius = region_.radius(unit)}; }

  /// Takes note of how PCG ended and what its step has brought.
  /// @return whether another step may help.
  bool take_step(const PcgScalars& end, double unit, const StepTaken& step);

  /// Steps of this iteration were bounded by the region.
  bool bounded() const { return bounded_; }

 private:
  TrustRegion region_;
  int failures_ = 0;  // in a row
  bool bounded_ = false;
};

/// Whether the first matrix is corrected for folds (precondition/fold_patch.hpp): after a linear system
/// that took many PCG iterations, until one takes few without folds.
class FoldWatch {
 public:
  bool looks() const { return looks_; }
  void take(int iterations, bool has_folds) {
    constexpr int kQuick = 8;  // iterations that need no correction
    if (iterations > kQuick)
      looks_ = true;
    else if (!has_folds)
      looks_ = false;
  }

 private:
  bool looks_ = false;
};

}  // namespace elastogen
