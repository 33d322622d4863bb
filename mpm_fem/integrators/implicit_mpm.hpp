// SPDX-License-Identifier: Apache-2.0
// Implicit steps of the material point method: Euler's, with plastic flow and contact within the
// equations (mpm_equations.hpp), solved by Newton's method on their true residual.

#pragma once

#include "core/krylov.hpp"
#include "core/report.hpp"
#include "mpm_fem/integrators/mpm_equations.hpp"
#include "mpm_fem/solve/nonsymmetric_solver.hpp"
#include "mpm_fem/solve/root.hpp"

namespace elastogen::mpm {

struct ImplicitMpmOptions {
  double tolerance = 1e-3;  ///< of |r| / |M g_ref|_{M^-1}
  int max_newton = 40;
  int substeps = 1;          ///< of a step, on fixed nodes between transfers
  int max_iterations = 400;  ///< of GMRES in a solve
  int64_t most_factored =
      20'000;  ///< unknowns of plane scenes, up to which LU factors may replace GMRES
};

/// outer counts Newton steps, inner iterations of GMRES.
struct MpmStepReport : StepReport {
  fem::RootStop stop = fem::RootStop::kConverged;
  int factored = 0;  ///< linear systems that GMRES did not solve
  int passes = 0;    ///< of FixedPointMpm
};

template <int d>
class ImplicitMpm {
 public:
  /// The scene must outlive it; its dt may change between steps.
  /// @throws Error as check_scene and point_law, and on substeps below 1.
  explicit ImplicitMpm(const MpmScene& scene, const ImplicitMpmOptions& options = {});

  /// Advances by scene.dt from `time` [s]. If the result is not finite the particles stay as they
  /// were and the report says so.
  MpmStepReport step(double time, Particles& particles);

  const std::vector<PointLaw<d>>& laws() const { return equations_.laws(); }

 private:
  bool find_step(const double* y, const double* r, double tolerance, double* step);
  fem::RootResult solve(std::vector<double>& y);

  const MpmScene& scene_;
  ImplicitMpmOptions options_;
  MpmEquations<d> equations_;
  GmresWork<double> work_{0};
  fem::NonsymmetricSolver factors_;
  int64_t pattern_ = -1;        // version of the pattern that factors_ have
  bool factors_first_ = false;  // GMRES did not converge earlier in this step
  int64_t factored_ = 0;        // matrices so far
  int64_t iterations_ = 0;
};

extern template class ImplicitMpm<2>;
extern template class ImplicitMpm<3>;

}  // namespace elastogen::mpm
