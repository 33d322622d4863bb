// SPDX-License-Identifier: Apache-2.0
// Data of particles for outputs, beside position and velocity. All are views of arrays that outlive
// the writers.

#pragma once

#include "core/array.hpp"

namespace elastogen {

/// Data that do not change during a run.
struct ParticleSet {
  Span<const double> mass;       ///< [kg], (particles, 1)
  Span<const double> volume;     ///< at rest [m^3], (particles, 1)
  Span<const int32_t> material;  ///< index into the scene's materials, (particles, 1)

  int64_t count() const { return mass.rows; }
};

/// Strain and stress of one frame.
struct ParticleStrain {
  Span<const double> F;       ///< elastic deformation gradient [-], row-major, (particles, 9)
  Span<const double> C;       ///< affine velocity [1/s], row-major, (particles, 9)
  Span<const double> stress;  ///< Kirchhoff's [Pa], xx yy zz xy yz zx, (particles, 6)
  Span<const double> memory;  ///< the law's internal variable [-], (particles, 1)
};

}  // namespace elastogen
