// SPDX-License-Identifier: Apache-2.0
// Particles of a run whose bodies fall apart into grains, and the cloud that outputs show.

#pragma once

#include "core/state.hpp"
#include "io/particle_frame.hpp"
#include "io/step_log.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// Fills the voxels of a setup with particles. They replace its nodes and carried points.
/// @throws Error (usage) if particles are to be held by a part of the asset or along axes, moved or
///         loaded, or if an output cannot show them.
void add_particles(const Asset& asset, const RunDescription& run, Setup& setup);

/// The asset that outputs show: for particles their cloud with the asset's colours, else the asset.
/// Asset and setup must outlive it.
const Asset& shown_asset(const Asset& asset, const Setup& setup);

/// The constant data of a setup's particles, which must outlive it.
ParticleSet particle_set(const ParticleSetup& particles);

/// Positions [m] and velocities [m/s] of a setup's particles at the start.
State particle_start(const Setup& setup, const StartMotion& motion);

/// Box and total volume of particles.
/// @param origin  origin of their coordinates [m]
CloudReport cloud_of(const mpm::Particles& particles, const Vec3& origin);

}  // namespace elastogen
