// SPDX-License-Identifier: Apache-2.0
// The yield limits of solids, in the numbers that experiments give. The yield surfaces bound the
// radius |dev tau|, while an experiment pulls a bar: with q = sqrt((6-d)/2) |dev tau| a bar in d
// dimensions has q = sigma.

#pragma once

#include "core/material.hpp"

#include <cmath>

namespace elastogen {

/// A metal: the stress of a bar that flows is sigma_Y + H eps_p.
struct MetalYield {
  double stress = 2.5e8;  ///< sigma_Y [Pa], > 0
  double hardening = 0;   ///< H [Pa], >= 0

  friend bool operator==(const MetalYield&, const MetalYield&) = default;
};

/// Sand, grains that hold by friction (Klar et al. 2016).
struct SandYield {
  double friction = 0.5236;  ///< angle of triaxial compression [rad], in [0, pi/2)
  double cohesion = 0;       ///< the Hencky strain in every direction that it bears [-], >= 0
  bool keeps_volume = true;  ///< whether an opening has to close before the sand bears again

  friend bool operator==(const SandYield&, const SandYield&) = default;
};

/// Snow, an ellipse of yield from pressure p0 to -beta p0 (Gaume et al. 2018).
struct SnowYield {
  double slope = 1.85;    ///< M of the critical state [-], > 0
  double cohesion = 0.5;  ///< beta, tensile strength over p0 [-], >= 0
  double hardening = 1;   ///< xi [-], > 0
  double pressure = 5e3;  ///< p0 at the start [Pa], in (1e-5, 0.45) of the bulk modulus

  friend bool operator==(const SnowYield&, const SnowYield&) = default;
};

/// sqrt((6-d)/2): uniaxial stress over |dev tau|, and strain |dev e| over uniaxial strain.
inline double yield_norm(int d) {
  return std::sqrt((6 - d) / 2.0);
}

/// lambda + 2 mu/d [Pa], the bulk modulus in d dimensions.
inline double bulk_modulus(const Material& material, int d) {
  return material.lambda() + 2 * material.mu() / d;
}

/// @throws Error unless both are within their ranges.
void check_yield(const Material& material, const MetalYield& yield);
void check_yield(const Material& material, const SandYield& yield);
void check_yield(const Material& material, const SnowYield& yield, int d);

}  // namespace elastogen
