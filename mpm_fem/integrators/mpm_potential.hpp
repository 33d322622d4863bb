// SPDX-License-Identifier: Apache-2.0
// The energy that an implicit step of particles would minimise if its laws had potentials and its
// colliders no friction. Frozen at a state y0, in the variables of mpm_equations.hpp,
//
//     E(y) = |y - M^1/2 uhat|^2/(2 dt^2) + sum_p V_p psi(F_p; F_p(y0)) - lambda.y,
//
// psi are the laws' potentials or, for laws without one, potentials frozen at y0 (frozen_law.hpp);
// dE/dy at y0 is r0 - lambda. Colliders hold the part of the motion that they held at y0, and
// lambda is their force there along the free part. So a y0 that is the minimum of its own E solves
// the true equations.

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

  /// Freezes at y, until thaw(). Call residual(y) before.
  /// @param drag  whether psi of solids that yield gets mu/2 |F - F(y0)|^2, PlasticityNet's
  ///              regulariser (Li et al. 2022, equation 11)
  void freeze(const double* y, bool drag);
  /// Returns to the true equations.
  void thaw() { is_frozen_ = false; }

  /// Moves y to where colliders hold it, as far as no particle inverts.
  void meet_obstacles(double* y);
  /// E [J] with the bound on its rounding error. The gradient is 0 in directions that colliders
  /// hold.
  fem::NewtonValue evaluate(const double* y, double* gradient);
  /// Prepares products with the Hessian of E at y, or with its positive part pack by pack. They are
  /// symmetric in directions that no collider holds.
  void linearise(const double* y, TangentKind kind);

 private:
  using Base = MpmEquations<d>;
  struct Held {  // of a node at a collider
    Mat3<double> free;
    Vec3 motion;  // [m]
    Vec3 load;    // lambda in the free directions
  };
  Mat3<Eight> piola(int64_t pack, const Mat3<Eight>& F) override;
  PrincipalHessian<Eight, Mat3<Eight>> piola_derivative(int64_t pack, const Svd3<Eight>& F,
                                                        Eight t[3]) override;
  void linearise_obstacles(const double* y) override;
  void freeze_obstacles(const double* y);
  Eight drag_of(int64_t pack) const;

  bool is_frozen_ = false, drags_ = false;
  TangentKind kind_ = TangentKind::kTrue;
  std::vector<FrozenPoint<d>> frozen_;  // of each particle
  std::vector<Mat3<Eight>> F0_;         // of each pack
  std::vector<Held> held_;
  std::vector<double> energy_, size_;  // of each pack, from the last call of piola [J]
};

extern template class MpmPotential<2>;
extern template class MpmPotential<3>;

}  // namespace elastogen::mpm
