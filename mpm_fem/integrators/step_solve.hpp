// SPDX-License-Identifier: Apache-2.0
// The solve of a step or of a stage: from a start value to the minimum of the potential that its
// scheme has set, with the certificate of the state that is returned.

#pragma once

#include "mpm_fem/integrators/equilibrium.hpp"

namespace elastogen::fem {

struct ImplicitOptions {
  double tolerance = 1e-8;  ///< of |grad Phi| / |M g_ref| over the free components
  int max_newton = 100;
  LinearOptions linear = {};
  /// Certifies and returns the displacements of positions in double precision, (X + u) - X, for
  /// states that are written as positions. Velocities are those before rounding.
  bool as_positions = false;
};

/// outer counts Newton steps, inner iterations of PCG and GMRES; min_corner_j is not filled.
/// StepReport::scheme says Euler in a Newmark step; used says Newmark.
struct FemStepReport : StepReport {
  Scheme used = Scheme::kEuler;
  NewtonStop stop = NewtonStop::kConverged;
  int parts = 1;     ///< parts in which it was made (parted_fem.hpp)
  int halvings = 0;  ///< tries at a part that failed; fallbacks counts them too
  double floor = 0;  ///< bound on the rounding error of the residual; 0 if not needed
};

/// The refusal of a step that a collider leaves no solution.
inline constexpr const char* kNoRoom = "a collider leaves the body no room";

class StepSolve {
 public:
  /// The scene must outlive it.
  /// @throws Error as FemPotential and on a tolerance or dt that is not positive.
  StepSolve(const FemScene& scene, const ImplicitOptions& options);

  const FemScene& scene() const { return scene_; }
  FemPotential& terms() { return terms_; }
  const FemPotential& terms() const { return terms_; }
  /// M g [N], (nodes, 3).
  const Array<double>& weight() const { return weight_; }
  double reference() const { return reference_; }  ///< |M g_ref| [N]
  int64_t iterations() const;                      ///< of PCG and GMRES in all solves so far
  /// Gradient of the last certificate [N], (nodes, 3), 0 at fixed components.
  const Array<double>& residual() const { return gradient_; }

  /// The displacements of lowest potential among the present ones and those of some predictors,
  /// with the fixed components and the dependent nodes moved to where they are at a time.
  Array<double> start_value(const Array<double>& now, std::vector<Array<double>> ahead,
                            double time);
  /// Moves the colliders through the step share by share where they would run into u, and lets u
  /// give way to each share. False: they leave it no space.
  bool pass_colliders(Array<double>& u);
  /// Moves u to the minimum, and writes the certificate and the cost but for inner.
  /// @return the displacements that the state gets for u
  Array<double> minimise(double tolerance, Array<double>& u, FemStepReport& report);
  /// Finds the residual of the equations and the energies for the state that is returned.
  void certify(double tolerance, const Array<double>& u, FemStepReport& report);

 private:
  Array<double> handed_out(const Array<double>& u) const;

  const FemScene& scene_;
  ImplicitOptions options_;
  FemPotential terms_;
  Potential& potential_;  // of the terms
  double reference_;
  Array<double> gradient_, weight_;
};

}  // namespace elastogen::fem
