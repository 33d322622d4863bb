// SPDX-License-Identifier: Apache-2.0
// What an implicit step of particles would minimise if its laws had potentials and its walls no
// friction. Frozen at a state y0, in the variables of mpm_equations.hpp,
//
//     E(y) = |y - M^1/2 uhat|^2/(2 dt^2) + sum_p V_p psi(F_p; F_p(y0)) - lambda.y,
//
// psi the laws' potentials, or where they have none the ones that are frozen at y0 (frozen_law.hpp);
// dE/dy at y0 is r0 - lambda. Walls hold what they held of the motion at y0, and lambda is the force
// along them there. So a y0 that is the minimum of its own E solves the true equations.

#pragma once

#include "core/tangent.hpp"
#include "mpm_fem/integrators/mpm_equations.hpp"
#include "mpm_fem/mpm/frozen_packs.hpp"
#include "mpm_fem/solve/newton.hpp"

namespace elastogen::mpm {

template <int d>
class MpmPotential final : public MpmEquations<d> {
 public:
  using MpmEquations<d>::MpmEquations;

  /// Freezes at y, until thaw. After residual(y).
  /// @param drag  whether psi of solids that yield gets mu/2 |F - F(y0)|^2, PlasticityNet's
  ///              regulariser (Li et al. 2022, equation 11)
  void freeze(const double* y, bool drag);
  /// Back to the true equations.
  void thaw() { is_frozen_ = false; }

  /// Moves y to where walls hold it, as far as no particle inverts.
  void meet_walls(double* y);
  /// E [J] with the bound on its rounding error. The gradient is 0 along what walls hold.
  fem::NewtonValue evaluate(const double* y, double* gradient);
  /// Prepares products with the Hessian of E at y, or with its positive part pack by pack. They are
  /// symmetric on what no wall holds.
  void linearise(const double* y, TangentKind kind);

 private:
  using Base = MpmEquations<d>;
  struct Held {  // of a node at a wall
    Mat3<double> free;
    Vec3 motion;  // [m]
    Vec3 load;    // lambda on what is free
  };
  Mat3<Eight> piola(int64_t pack, const Mat3<Eight>& F) override;
  PrincipalHessian<Eight, Mat3<Eight>> piola_derivative(int64_t pack, const Svd3<Eight>& F,
                                                        Eight t[3]) override;
  void linearise_walls(const double* y) override;
  void freeze_walls(const double* y);
  Eight drag_of(int64_t pack) const;

  bool is_frozen_ = false, drags_ = false;
  TangentKind kind_ = TangentKind::kTrue;
  std::vector<FrozenPoint<d>> frozen_;  // of each particle
  std::vector<Mat3<Eight>> F0_;         // of each pack
  std::vector<Held> held_;
  std::vector<double> energy_, size_;  // of each pack, where piola was asked last [J]
};

extern template class MpmPotential<2>;
extern template class MpmPotential<3>;

}  // namespace elastogen::mpm
