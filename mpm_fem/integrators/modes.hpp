// SPDX-License-Identifier: Apache-2.0
// Lowest vibrations about an equilibrium: K phi = omega^2 M phi, K the Hessian of the elastic
// energy, by shift-invert Lanczos.

#pragma once

#include "mpm_fem/fem_scene.hpp"

#include <vector>

namespace elastogen::fem {

struct Modes {
  std::vector<double> omega_squared;  ///< [1/s^2], ascending; about 0 of rigid motions
  std::vector<double> frequency;      ///< [Hz], sqrt(omega^2)/(2 pi), 0 where omega^2 < 0
  Array<double> shape;  ///< row k: mode k, phi.M phi = 1 [1/sqrt(kg)], (modes, 3 nodes)
};

/// The modes with the lowest omega^2. Nothing needs to be fixed.
/// @param u  where the body is linearised [m], (nodes, 3); empty: at rest
/// @throws Error unless 1 <= count < free unknowns; (diverged) where the iteration finds no modes.
Modes vibration_modes(const FemScene& scene, int count, const Array<double>& u = {});

}  // namespace elastogen::fem
