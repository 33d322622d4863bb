// SPDX-License-Identifier: Apache-2.0
// Dead loads of a run on the nodes of its mesh.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// The given nodes of the grid, and the middles of edges between two of them, (nodes of the mesh, 1).
Array<uint8_t> with_middles(const Array<uint8_t>& grid_nodes, const fem::ElementMesh& mesh);

/// Forces of the run that change with time, spread over the nodes in them by mass.
/// @param mass  of the nodes of the mesh [kg], (nodes, 1).
/// @throws Error (usage) naming a force that selects no node.
std::vector<TimedForce> timed_forces(const Setup& setup, const RunDescription& run,
                                     const fem::ElementMesh& mesh, const Array<double>& mass);

/// Adds tractions and forces to a finished scene of the network.
void add_forces(const RunDescription& run, Setup& setup);

/// Adds wind to a finished scene of voxels.
/// @throws Error (usage) for statics.
void add_wind(const RunDescription& run, Setup& setup);

/// Loads of the tractions of a run [N], (nodes, 3); empty: there is none.
/// @throws Error (usage) naming a traction that selects no face.
Array<double> surface_loads(const Setup& setup, const RunDescription& run,
                            const fem::ElementMesh& mesh);

}  // namespace elastogen
