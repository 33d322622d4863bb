// SPDX-License-Identifier: Apache-2.0
// What pins and moves do to the body as finite elements: reactions at the end of time steps and of
// statics (docs/physics.md, section 3b).

#pragma once

#include "core/held_nodes.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// The nodes of a mesh with what holds them, as HeldNodes reads them; middles of edges between two
/// pinned nodes are pinned too.
Scene nodes_with_holders(const Setup& setup, const fem::ElementMesh& mesh);

class FemHolders {
 public:
  /// The scene must outlive it.
  FemHolders(const Setup& setup, const fem::FemScene& scene);
  FemHolders(const FemHolders&) = delete;
  FemHolders& operator=(const FemHolders&) = delete;

  /// Of each holder, at the end of a step.
  /// @param forces  ImplicitFem::holding() or StageFem::holding() [N], (nodes, 3).
  /// @param u       displacements there [m], (nodes, 3).
  std::vector<Reaction> reactions(Array<double> forces, In<double> u, double time) const;
  /// Under the whole load; none without an equilibrium.
  std::vector<Reaction> reactions(const fem::StaticResult& result) const;

 private:
  std::vector<Reaction> of_forces(Array<double> forces, In<double> u) const;

  const fem::FemScene& scene_;
  Scene nodes_;
  HeldNodes held_;
  Array<double> held_mass_;  // of each node, of elements that are held whole [kg]
  Array<double> mass_;       // of each node [kg]
};

}  // namespace elastogen
