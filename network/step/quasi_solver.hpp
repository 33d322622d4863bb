// SPDX-License-Identifier: Apache-2.0
// The quasi mode (quasi_loop.hpp) on the host.

#pragma once

#include "network/precondition/preconditioner.hpp"
#include "network/step/iteration.hpp"
#include "network/step/lbfgs.hpp"

namespace elastogen {

template <class T>
class QuasiSolver {
 public:
  explicit QuasiSolver(IncrementalPotential& potential);

  /// quasi_loop on u, with gradients in T.
  /// @tparam P  precision of the preconditioner.
  template <class P>
  IterationResult solve(double* u, double target, int max_outer, Preconditioner<P>& first,
                        const Interrupted& interrupted);

 private:
  template <class P>
  struct Work;

  IncrementalPotential& potential_;
  int64_t size_;
  std::vector<double> trial_u_;
  std::vector<T> gradient_, trial_gradient_, direction_, scratch_;
  Lbfgs<T> history_;
};

}  // namespace elastogen
