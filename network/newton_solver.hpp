// SPDX-License-Identifier: Apache-2.0
// The newton mode: projected Hessian, PCG with V-cycle and encoder to an Eisenstat-Walker forcing
// term, line search on the true potential. Gradients are float64, corrections float.

#pragma once

#include "core/pcg.hpp"
#include "network/quasi_solver.hpp"

namespace elastogen {

/// Eisenstat and Walker's second choice with safeguards: how far the linear system of a Newton step
/// is solved, from the present residual, the one before (0: none) and the last choice.
double forcing_term(double residual, double before, double last, double target);

class NewtonSolver {
 public:
  explicit NewtonSolver(IncrementalPotential& potential);

  /// Improves u until |grad Phi|_2 <= target [N]; outer counts Newton steps, inner PCG iterations.
  template <class P>
  IterationResult solve(double* u, double target, int max_outer, int max_inner,
                        Preconditioner<P>& preconditioner,
                        const std::function<bool()>& interrupted);

 private:
  bool line_search(double* u, PotentialValue& value);

  IncrementalPotential& potential_;
  int64_t size_;
  std::vector<double> trial_u_, gradient_, trial_gradient_;
  std::vector<float> right_, step_;
  PcgWork<float> work_;
};

}  // namespace elastogen
