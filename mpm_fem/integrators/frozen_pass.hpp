// SPDX-License-Identifier: Apache-2.0
// Minima of a step of particles with the plastic part frozen (mpm_potential.hpp), by projected
// Newton's steps with conjugate gradients.

#pragma once

#include "core/pcg.hpp"
#include "mpm_fem/integrators/mpm_potential.hpp"

namespace elastogen::mpm {

template <int d>
class FrozenPass {
 public:
  /// The potential must outlive it.
  /// @param max_iterations  of conjugate gradients in a solve
  FrozenPass(MpmPotential<d>& potential, int max_iterations)
      : potential_(potential), max_iterations_(max_iterations) {}

  /// Freezes at y, moves y to a minimum and thaws. Call residual(y) before.
  /// @param drag     as MpmPotential::freeze
  /// @param options  the tolerance is of |dE/dy|
  fem::NewtonResult take(bool drag, const fem::NewtonOptions& options, double* y);

  int64_t iterations() const { return iterations_; }  ///< of conjugate gradients so far

 private:
  bool find_step(const double* y, const double* gradient, TangentKind kind, double tolerance,
                 double* step);

  MpmPotential<d>& potential_;
  int max_iterations_;
  PcgWork<double> work_{0};
  int64_t iterations_ = 0;
};

extern template class FrozenPass<2>;
extern template class FrozenPass<3>;

}  // namespace elastogen::mpm
