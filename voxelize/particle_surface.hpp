// SPDX-License-Identifier: Apache-2.0
// Surfaces and volumes of particles by OpenVDB. Spheres of the particles' volumes are grown by a
// spacing so that neighbours join, smoothed, and shrunk until they enclose the particles' volume.

#pragma once

#include "core/array.hpp"
#include "core/base.hpp"

#include <string>
#include <vector>

namespace elastogen {

struct ParticleCloud {
  Span<const double> x;       ///< [m], (particles, 3)
  Span<const double> volume;  ///< [m^3], (particles, 1)
  double spacing = 0;         ///< of the particles at rest [m]
};

/// Triangles that bound a solid: every edge belongs to two of them, once in each direction.
struct ParticleSurface {
  std::vector<Vec3> position;                    ///< of vertices [m]
  std::vector<std::array<int32_t, 3>> triangle;  ///< vertices, counter-clockwise from outside
};

/// The surface of particles, computed with cells of two thirds of the spacing. A single particle
/// becomes a ball of its volume; gaps narrower than about two spacings are closed. Any number of
/// threads gives the same bits.
/// @throws Error (usage) on shapes that do not fit, or a spacing that is not positive.
ParticleSurface particle_surface(const ParticleCloud& cloud);

/// The particle nearest to each point, the first of several.
/// @param x        of the particles [m], (particles, 3)
/// @param spacing  approximate spacing of the particles, the first radius of the search [m]
/// @param points   [m]
std::vector<int32_t> nearest_particles(In<double> x, double spacing,
                                       const std::vector<Vec3>& points);

/// Writes a `.vdb` in metres with the float grids `density` (fog volume: 1 inside, a ramp to 0 at
/// the surface) and `surface` (level set), and the vector grid `velocity` [m/s]: the particles'
/// mean, weighted by volume, in cells of two spacings. Floats have 16 bits.
/// @param v      of the particles [m/s], (particles, 3)
/// @param place  place of the cloud's origin in the asset's coordinates [m]
/// @throws Error (usage) also if OpenVDB cannot hold cells as small; (resources) if the file cannot
///         be written.
void write_particle_vdb(const std::string& path, const ParticleCloud& cloud, In<double> v,
                        const Vec3& place);

}  // namespace elastogen
