// SPDX-License-Identifier: Apache-2.0
// The particles of a run whose bodies fall apart into grains, and the cloud that its outputs show.

#pragma once

#include "core/state.hpp"
#include "io/particle_frame.hpp"
#include "io/step_log.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// Fills the voxels of a setup with particles, which take the place of its grid's nodes and of the
/// points that it carries.
/// @throws Error (usage) for what particles cannot do: be held, moved or loaded, or be shown by an
///         output.
void add_particles(const Asset& asset, const RunDescription& run, Setup& setup);

/// What outputs show of a run: the asset, or where it has particles these as a cloud of points with
/// the asset's colours. Asset and setup must outlive it.
const Asset& shown_asset(const Asset& asset, const Setup& setup);

/// What stays the same of a setup's particles, which must outlive it.
ParticleSet particle_set(const ParticleSetup& particles);

/// Places [m] and velocities [m/s] of a setup's particles at the start.
State particle_start(const Setup& setup, const StartMotion& motion);

/// Box and volume of particles.
/// @param origin  of their numbers [m]
CloudReport cloud_of(const mpm::Particles& particles, const Vec3& origin);

}  // namespace elastogen
