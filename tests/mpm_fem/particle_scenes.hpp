// SPDX-License-Identifier: Apache-2.0
// Scenes of the tests of particles.

#pragma once

#include "mpm_fem/mpm/mpm_scene.hpp"
#include "tests/support/matrices.hpp"

#include <cmath>

namespace elastogen::test {

using mpm::MpmScene, mpm::Particles;

inline constexpr double kH = 0.1;

inline Solid particle_solid(double young, double density) {
  Solid s;
  s.elastic = {"test", Law::kHencky, young, 0.3, density};
  return s;
}

inline MpmScene particle_scene(int dimension) {
  MpmScene s;
  s.dimension = dimension;
  s.h = kH;
  s.dt = 1e-3;
  s.solids = {particle_solid(1e4, 1000)};
  return s;
}

/// Particles at random in a unit cube or square, with velocities and affine parts at random.
template <int d>
Particles random_particles(int64_t count, uint64_t seed) {
  Random random(seed);
  std::uniform_real_distribution<double> in(-0.5, 0.5);
  Array<double> x(count, 3);
  for (int64_t k = 0; k < count; ++k)
    for (int a = 0; a < d; ++a) x(k, a) = in(random);
  Particles p = mpm::particles_at(x, 1.0 / double(count), 0, 1000);
  for (int64_t k = 0; k < count; ++k)
    for (int a = 0; a < d; ++a) {
      p.v(k, a) = in(random);
      for (int b = 0; b < d; ++b) p.C(k, 3 * a + b) = in(random);
    }
  return p;
}

/// A column in the plane, `width` and `height` cells of four particles each, its foot at y = 0 and
/// its middle at x = 0.
inline Particles column(int width, int height) {
  Array<double> x(4 * width * height, 3);
  for (int64_t k = 0; k < x.rows(); ++k) {
    x(k, 0) = kH / 2 * (double(k % (2 * width)) + 0.5 - width);
    x(k, 1) = kH / 2 * (double(k / (2 * width)) + 0.5);
  }
  return mpm::particles_at(x, kH * kH / 4, 0, 1000);
}

/// Rough ground at y = 0 and gravity of 10 m/s^2, or ground with friction.
inline MpmScene column_scene(const Solid& solid, double dt, double friction = -1) {
  MpmScene s = particle_scene(2);
  s.solids = {solid};
  s.dt = dt;
  s.gravity = {0, -10, 0};
  s.obstacles.push_back({half_space({0, 1, 0}, 0, std::fmax(friction, 0)), friction < 0});
  return s;
}

inline Solid sand(double young, double friction = 0.5, bool keeps_volume = false) {
  Solid s = particle_solid(young, 1000);
  s.yield = SandYield{.friction = friction, .keeps_volume = keeps_volume};
  return s;
}

}  // namespace elastogen::test
