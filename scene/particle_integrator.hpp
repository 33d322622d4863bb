// SPDX-License-Identifier: Apache-2.0
// The integrators of particles behind one door, in space or in the plane.

#pragma once

#include "mpm_fem/integrators/implicit_mpm.hpp"
#include "scene/set_up.hpp"

#include <memory>
#include <string_view>

namespace elastogen {

class ParticleIntegrator {
 public:
  virtual ~ParticleIntegrator() = default;

  /// Advances by the scene's dt from `time` [s]. Explicit steps have no residual, and are converged
  /// where their result is finite. What a step that is not finite leaves is of no use.
  virtual mpm::MpmStepReport step(double time, mpm::Particles& particles) = 0;

  /// sum V psi [J]
  virtual double elastic_energy(const mpm::Particles& particles) const = 0;
};

/// As it is chosen: "implicit", "explicit", ...
std::string_view integrator_name(Integrator integrator);

/// Solids, walls, gravity and transfers of a setup; dt is to be set.
mpm::MpmScene mpm_scene(const Setup& setup, const ParticleOptions& options);

/// h/c of the fastest solid [s]: explicit steps above it are never stable, below a half of it they
/// mostly are.
double crossing_time(const mpm::MpmScene& scene);

/// From one transfer to the next where the options do not say: explicit substeps of 0.3 h/c.
double explicit_dt(const mpm::MpmScene& scene, const ParticleOptions& options);

/// @param scene  which must outlive it; its dt may change between steps.
/// @throws Error (usage) where dt of explicit steps cannot be stable.
std::unique_ptr<ParticleIntegrator> make_particle_integrator(const mpm::MpmScene& scene,
                                                             const ParticleOptions& options,
                                                             double tolerance);

}  // namespace elastogen
