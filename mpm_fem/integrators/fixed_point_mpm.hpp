// SPDX-License-Identifier: Apache-2.0
// Implicit steps of the material point method by repeated minima: freeze at the present state what
// keeps the stress from having a potential, minimise, freeze again (mpm_potential.hpp). Newton's
// method on the true residual (implicit_mpm.hpp) is compared with this.

#pragma once

#include "mpm_fem/integrators/frozen_pass.hpp"
#include "mpm_fem/integrators/implicit_mpm.hpp"

namespace elastogen::mpm {

struct FixedPointOptions {
  double tolerance = 1e-3;  ///< of |r| / |M g_ref|_{M^-1}, of each minimum and of the true residual
  int passes = 40;          ///< at most

  /// Runs the loop of PlasticityNet (Li et al. 2022, equations 10 and 11): from the old positions
  /// of the particles, with its regulariser, and always with all passes.
  bool published = false;
  int max_newton = 100;       ///< of a minimum
  int max_iterations = 1000;  ///< of conjugate gradients in a solve
};

template <int d>
class FixedPointMpm {
 public:
  /// The scene must outlive it; its dt may change between steps.
  explicit FixedPointMpm(const MpmScene& scene, const FixedPointOptions& options = {});

  /// As ImplicitMpm::step. outer counts the Newton steps of all passes, inner iterations of
  /// conjugate gradients; the residual is the true one.
  MpmStepReport step(double time, Particles& particles);

  const std::vector<PointLaw<d>>& laws() const { return potential_.laws(); }

 private:
  double true_residual(const std::vector<double>& y);

  FixedPointOptions options_;
  const MpmScene& scene_;
  MpmPotential<d> potential_;
  FrozenPass<d> pass_;
  std::vector<double> r_;
};

extern template class FixedPointMpm<2>;
extern template class FixedPointMpm<3>;

}  // namespace elastogen::mpm
