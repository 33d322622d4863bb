// SPDX-License-Identifier: Apache-2.0
// One interface to the integrators of particles, in space and in the plane.

#pragma once

#include "mpm_fem/integrators/implicit_mpm.hpp"
#include "scene/set_up.hpp"

#include <memory>
#include <string_view>

namespace elastogen {

class ParticleIntegrator {
 public:
  virtual ~ParticleIntegrator() = default;

  /// Advances by the scene's dt from `time` [s]. Explicit steps have no residual and count as
  /// converged if their result is finite. After one that is not finite particles are invalid.
  virtual mpm::MpmStepReport step(double time, mpm::Particles& particles) = 0;

  /// sum V psi of the elastic strain [J]
  virtual double elastic_energy(const mpm::Particles& particles) const = 0;
};

/// The name by which it is chosen: "implicit", "explicit", ...
std::string_view integrator_name(Integrator integrator);

/// Solids, colliders, gravity and transfers of a setup; the caller sets dt.
mpm::MpmScene mpm_scene(const Setup& setup, const ParticleOptions& options);

/// h/c of the fastest solid [s]. Explicit steps above it are never stable, below half of it mostly.
double crossing_time(const mpm::MpmScene& scene);

/// Default time between two transfers: explicit substeps of 0.3 h/c.
double explicit_dt(const mpm::MpmScene& scene, const ParticleOptions& options);

/// @param scene  must outlive it; its dt may change between steps.
/// @throws Error (usage) if dt of explicit steps cannot be stable.
std::unique_ptr<ParticleIntegrator> make_particle_integrator(const mpm::MpmScene& scene,
                                                             const ParticleOptions& options,
                                                             double tolerance);

}  // namespace elastogen
