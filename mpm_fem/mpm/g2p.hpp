// SPDX-License-Identifier: Apache-2.0
// Grid to particles: places and velocities after a step.

#pragma once

#include "mpm_fem/mpm/mpm_scene.hpp"
#include "mpm_fem/mpm/transfer.hpp"

namespace elastogen::mpm {

/// Moves the particles with the nodes and gives them velocities as the transfer says.
/// @param motion  of the nodes in the step [m], (nodes, 3)
/// @param before  velocities of the nodes at its start, as they came from the particles [m/s]
/// @param after   at its end [m/s]
template <int d>
void grid_to_particles(const ParticleGrid<d>& grid, In<double> motion, In<double> before,
                       In<double> after, const TransferOptions& transfer, double dt,
                       Particles& particles);

}  // namespace elastogen::mpm
