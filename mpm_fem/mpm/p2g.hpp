// SPDX-License-Identifier: Apache-2.0
// Particles to grid: mass and velocity of the nodes, and the forces of the particles' stress.

#pragma once

#include "mpm_fem/mpm/mpm_scene.hpp"
#include "mpm_fem/mpm/transfer.hpp"

namespace elastogen::mpm {

struct NodeMotion {
  Array<double> mass;      ///< m_i = sum w m [kg], (nodes, 1)
  Array<double> velocity;  ///< v_i = sum w m (v + C (x_i - x)) / m_i [m/s], (nodes, 3)
};

/// Nodes with a mass below 1e-12 of a particle's mean have velocity and mass 0.
/// @param dt  time for which the particles' stress has acted on the velocities [s]
template <int d>
NodeMotion particles_to_grid(const ParticleGrid<d>& grid, const Particles& particles,
                             Zeroed<double>& scratch, double dt = 0);

}  // namespace elastogen::mpm
