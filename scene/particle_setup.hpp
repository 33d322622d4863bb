// SPDX-License-Identifier: Apache-2.0
// The particles of a run whose bodies fall apart into grains, and the cloud that its outputs show.

#pragma once

#include "core/state.hpp"
#include "io/step_log.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// Fills the voxels of a setup with particles, which take the place of its grid's nodes and of the
/// points that it carries.
/// @throws Error (usage) for what particles cannot do: be held, moved or loaded, or write states.
void add_particles(const RunDescription& run, Setup& setup);

/// What outputs show of a run: the asset, or where it has particles these as a cloud of points. They
/// have the colour of the triangle of a mesh that is nearest to their voxel: the base colour of its
/// material, without its texture, times the mean colour of its corners.
Asset shown_asset(const Asset& asset, const Setup& setup);

/// Places [m] and velocities [m/s] of a setup's particles at the start.
State particle_start(const Setup& setup, const StartMotion& motion);

/// Box and volume of particles.
/// @param origin  of their numbers [m]
CloudReport cloud_of(const mpm::Particles& particles, const Vec3& origin);

}  // namespace elastogen
