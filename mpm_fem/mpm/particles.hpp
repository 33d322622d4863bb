// SPDX-License-Identifier: Apache-2.0
// Particles of the material point method: pieces of bodies with mass, motion and strain of their
// own, which a grid moves.

#pragma once

#include "core/array.hpp"
#include "core/vec3.hpp"
#include "mpm_fem/materials/solid.hpp"

#include <vector>

namespace elastogen::mpm {

/// In the plane (d = 2) third components are 0, and F_33 = 1.
struct Particles {
  Array<double> x, v;  ///< [m], [m/s], (count, 3)
  Array<double> C;     ///< affine velocity, v + C (y - x) around x [1/s], (count, 9)
  Array<double> F;     ///< elastic deformation gradient [-], (count, 9)
  Array<double>
      stress;  ///< Kirchhoff stress after the last step [Pa], xx yy zz xy yz zx, (count, 6)
  Array<double> history;       ///< of the law (history_of), (count, 1)
  Array<double> mass, volume;  ///< [kg], at rest [m^3], (count, 1); in the plane per metre
  Array<int32_t> solid;        ///< index into the scene's solids, (count, 1)

  int64_t count() const { return x.rows(); }
};

/// Particles at rest without strain.
/// @param x       [m], (count, 3)
/// @param volume  of each [m^3]
Particles particles_at(In<double> x, double volume, int32_t solid, double density);

/// Appends others.
void append(Particles& particles, const Particles& others);

/// sum m [kg], sum m v [kg m/s], sum m x^v + the affine part's sum m (h^2/4) C^ [kg m^2/s].
struct Momentum {
  double mass = 0;
  Vec3 linear = {}, angular = {};
};

/// @param h  grid spacing [m]; the affine part is that of quadratic splines
Momentum momentum(const Particles& particles, double h);

/// sum m |v|^2/2 + m (h^2/8) |C|^2 [J]: the energy that particles bring to the grid, before the
/// grid smooths it.
double kinetic_energy(const Particles& particles, double h);

}  // namespace elastogen::mpm
