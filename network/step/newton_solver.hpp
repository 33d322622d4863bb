// SPDX-License-Identifier: Apache-2.0
// The newton mode (newton_loop.hpp) on the host.

#pragma once

#include "core/pcg.hpp"
#include "network/precondition/preconditioner.hpp"
#include "network/step/iteration.hpp"
#include "network/step/newton_region.hpp"

namespace elastogen {

class NewtonSolver {
 public:
  explicit NewtonSolver(IncrementalPotential& potential);

  /// newton_loop on u.
  /// @tparam P  precision of the preconditioner.
  template <class P>
  IterationResult solve(double* u, double target, int max_outer, int max_inner,
                        Preconditioner<P>& preconditioner, const Interrupted& interrupted);

 private:
  template <class P>
  struct Work;

  IncrementalPotential& potential_;
  int64_t size_;
  std::vector<double> trial_u_, gradient_, trial_gradient_;
  std::vector<float> right_, step_;
  PcgWork<float> pcg_;
  NewtonRegion region_;
  FoldWatch folds_;
};

}  // namespace elastogen
