// SPDX-License-Identifier: Apache-2.0
// Explicit time steps: symplectic Euler with the lumped mass,
//
//     v' = v + dt M^-1 (f - dE/du(u)) + dt g,   u' = u + dt v',
//
// with the flow committed at u. The barrier of colliders pushes from where they are at the start of
// the step, and friction reduces v' along them by at most friction N dt/m (Coulomb's law, stick
// included). Stable if a wave crosses no element in a step. Implicit steps are compared with these.

#pragma once

#include "mpm_fem/integrators/fem_potential.hpp"
#include "mpm_fem/integrators/fem_state.hpp"

namespace elastogen::fem {

class ExplicitFem {
 public:
  /// The scene must outlive the integrator.
  /// @throws Error as FemPotential; unless the mass is lumped, dt positive and every contact point
  ///         carried by one node; on voxel elements, whose torsion needs frozen rotations; on
  ///         damping; on dependent nodes, with which no mass is lumped.
  explicit ExplicitFem(const FemScene& scene);

  /// Advances the state by dt; the flow is kept here, not in the state. Same bits on every run and
  /// any number of threads.
  /// @throws Error unless the arrays of the state are (nodes, 3).
  void step(FemState& state);

  /// Push of each collider on the body at the start of the last step [N].
  const std::vector<Vec3>& pushes() const { return pushes_; }

 private:
  const FemScene& scene_;
  FemPotential terms_;
  Array<double> gradient_;
  std::vector<Vec3> pushes_;
};

}  // namespace elastogen::fem
