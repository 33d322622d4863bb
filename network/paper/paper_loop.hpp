// SPDX-License-Identifier: Apache-2.0
// The loops of the published algorithm (paper_solver.hpp) on either machine.

#pragma once

#include "network/solver.hpp"
#include "network/step/iteration.hpp"

namespace elastogen {

/// A machine that holds u and the lagged quadratic of the voxels: paper_solver.cpp on the host,
/// paper_solver.cu on a card. All but wait() may return before they have ended.
template <class Work>
concept PaperWork = requires(Work& work) {
  work.begin();    ///< u = xhat - X
  work.freeze();   ///< RNN-1: N and R of every voxel at u
  work.project();  ///< RNN-2's encoder: Galerkin step over the cosine modes
  work.sweep();    ///< RNN-2: one Jacobi sweep
  work.wait();
};

/// Never says converged: the certificate does.
/// @return outer counts loops, inner sweeps.
template <PaperWork Work>
IterationResult paper_loop(Work& work, const PaperLoops& loops, const Interrupted& interrupted) {
  IterationResult result;
  work.begin();
  for (int k = 0; k < loops.outer && !interrupted(); ++k) {
    work.freeze();
    if (loops.modes > 0) work.project();
    for (int s = 0; s < loops.inner && !interrupted(); ++s) work.sweep();
    work.wait();
    ++result.outer;
    result.inner += loops.inner;
  }
  return result;
}

}  // namespace elastogen
