// SPDX-License-Identifier: Apache-2.0
// The quasi mode: L-BFGS(5) whose first matrix is one pass of the preconditioner; no Hessian is
// formed. Liu, Bouaziz, Kavan 2017 with multigrid in place of a factorised matrix.

#pragma once

#include "network/lbfgs.hpp"
#include "network/preconditioner.hpp"

#include <functional>

namespace elastogen {

/// How an iteration over the potential ended.
struct IterationResult {
  bool converged = false;  ///< |gradient| <= target in the precision of the iteration
  int outer = 0, inner = 0;
  bool bounded = false;  ///< a trust region has cut steps: Phi is not convex there
};

/// One iteration after another.
inline IterationResult sum(const IterationResult& a, const IterationResult& b) {
  return {b.converged, a.outer + b.outer, a.inner + b.inner, a.bounded || b.bounded};
}

template <class T>
class QuasiSolver {
 public:
  explicit QuasiSolver(IncrementalPotential& potential);

  /// Improves u until |grad Phi|_2 <= target [N], at most max_outer iterations; in float it also
  /// ends where 25 iterations did not halve the gradient: the rest is for float64.
  /// @tparam P  precision of the preconditioner.
  template <class P>
  IterationResult solve(double* u, double target, int max_outer, Preconditioner<P>& first,
                        const std::function<bool()>& interrupted);

 private:
  bool line_search(const double* u, double slope, PotentialValue& value, int& evaluations);

  IncrementalPotential& potential_;
  int64_t size_;
  std::vector<double> trial_u_;
  std::vector<T> gradient_, trial_gradient_, direction_, work_;
  Lbfgs<T> history_;
};

}  // namespace elastogen
