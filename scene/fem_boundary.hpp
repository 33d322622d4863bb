// SPDX-License-Identifier: Apache-2.0
// Pins, holds, tractions and moves of a run as conditions on the nodes of finite elements.

#pragma once

#include "mpm_fem/fem_scene.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// Time of the last key of all moves [s].
double end_of_moves(const RunDescription& run);

/// Forces of the run that change with time, on the nodes of a scene that has its mesh.
/// @throws Error as timed_forces
std::vector<TimedForce> fem_forces(const Setup& setup, const RunDescription& run,
                                   const fem::FemScene& scene);

/// Fills fixed, dependent, traction, force, in_wind and motion of a scene that has its mesh. Holds and moves leave
/// dependent nodes to the pin that they follow. In a static run the load factor is the share of the
/// last key's time at which the motion is evaluated.
/// @throws Error (usage) naming the selections if a node is moved and held or moved twice, or if a
///         traction selects no face.
/// @param whole  the elements before pins cut them, whose faces take tractions.
void add_boundary(const Setup& setup, const RunDescription& run, const fem::ElementMesh& whole,
                  fem::FemScene& scene);

/// A sentence for each piece of the mesh that is free along some axis, with no displacement
/// component prescribed nor a dependent node. Statics then have no equilibrium unless the loads
/// cancel. Names the first few pieces and counts the others.
std::vector<std::string> unheld_pieces(const fem::FemScene& scene);

}  // namespace elastogen
