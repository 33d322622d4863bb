// SPDX-License-Identifier: Apache-2.0
// The potential of a finite element scene: the elements of its mesh, its colliders, its mass. The
// elements whose material yields are a term of their own, and so is damping; a scene without any has
// none.

#pragma once

#include "mpm_fem/fem_scene.hpp"
#include "mpm_fem/solve/elastic_term.hpp"
#include "mpm_fem/solve/plastic_term.hpp"
#include "mpm_fem/solve/potential.hpp"
#include "mpm_fem/solve/viscous_term.hpp"

#include <memory>

namespace elastogen::fem {

/// The scene must outlive it.
struct FemPotential {
  /// @throws Error as ElasticTerm, PlasticTerm, MassMatrix, ColliderContact and Potential, unless
  ///         there are no yields or one for each material, and where one is damped and one yields.
  explicit FemPotential(const FemScene& scene, const LinearOptions& options = {});

  /// Sets where dependent nodes are to be at a time (FemScene::dependent_motion).
  void move_dependent(double time);
  void freeze_rotations(In<double> u) {
    if (elastic) elastic->body().freeze_rotations(u);
  }
  /// Begins the damping of a step, as ViscousBody::begin.
  void begin_damping(double rate, In<double> u, double weight, In<double> other) {
    if (viscous) viscous->body().begin(rate, u, weight, other);
  }
  /// Power that damping takes at u, the end of the step [W].
  double damping_power(In<double> u) const {
    return viscous ? 2 * viscous->body().rate() * viscous->body().energy(u) : 0;
  }
  /// E(u) in its parts; materials that yield have the elastic energy at the end of a step that ends
  /// at u, and the plastic work in it.
  EnergyParts energy(In<double> u) const;
  double min_j(In<double> u) const;  ///< smallest det F of a quadrature point
  double length() const;             ///< mean edge of an element [m]

  std::unique_ptr<ElasticTerm> elastic;  ///< null where every element yields
  std::unique_ptr<PlasticTerm> plastic;  ///< null where none does
  std::unique_ptr<ViscousTerm> viscous;  ///< null where nothing is damped
  ColliderContact contact;               ///< a term of the potential where it exists
  Potential potential;

 private:
  const FemScene& scene_;
};

}  // namespace elastogen::fem
