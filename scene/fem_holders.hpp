// SPDX-License-Identifier: Apache-2.0
// What pins, moves and holds along axes do to the body as finite elements: reactions at the end of time
// steps and of statics (docs/physics.md, section 3b).

#pragma once

#include "core/held_nodes.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "mpm_fem/solve/mass_matrix.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// The nodes of a mesh with what holds them, as HeldNodes reads them; middles of edges between two
/// pinned nodes are pinned too. Without holds along axes.
Scene nodes_with_holders(const Setup& setup, const fem::ElementMesh& mesh);
/// Scene::fixed of the holds of a run at these nodes, in the order in which they were typed.
Array<int32_t> holders_of_axes(const Setup& setup, const RunDescription& run,
                               const fem::ElementMesh& mesh, const Scene& nodes);

class FemHolders {
 public:
  /// The scene must outlive it.
  FemHolders(const Setup& setup, const RunDescription& run, const fem::FemScene& scene);
  FemHolders(const FemHolders&) = delete;
  FemHolders& operator=(const FemHolders&) = delete;

  /// Of each holder, at the end of a step.
  /// @param forces  ImplicitFem::holding() or StageFem::holding() [N], (nodes, 3).
  /// @param loads   those of their loads() [N], (nodes, 3).
  /// @param u       displacements there [m], (nodes, 3).
  std::vector<Reaction> reactions(Array<double> forces, In<double> loads, In<double> u,
                                  double time);
  /// Under the whole load; none without an equilibrium.
  std::vector<Reaction> reactions(const fem::StaticResult& result) const;

 private:
  bool is_held(int64_t node, int axis) const;
  void add_inertia(In<double> u, Array<double>& forces) const;
  std::vector<Reaction> of_forces(Array<double> forces, In<double> u) const;

  const fem::FemScene& scene_;
  Scene nodes_;
  HeldNodes held_;
  std::optional<fem::MassMatrix> mass_, held_mass_;  // of all; of what is held whole, if it exists
  Array<double> weights_, held_weights_;             // their products with gravity [N], (nodes, 3)
};

}  // namespace elastogen
