// SPDX-License-Identifier: Apache-2.0
// The scene of the particle integrators.

#pragma once

#include "mpm_fem/mpm/obstacles.hpp"
#include "mpm_fem/mpm/particles.hpp"

#include <vector>

namespace elastogen::mpm {

/// How particles get their velocity from the nodes, v_i after a step and v_i^n before it. kApic:
/// v = sum w v_i with the affine part C = 4/h^2 sum w v_i (x_i - x)^T (Jiang et al. 2015). kBlend:
/// kApic plus the share 1 - dt/blend_time of the velocity and of C that the grid smoothed away, so
/// that the smoothing does not depend on the step. kRpic: the antisymmetric part of C only. kFlip:
/// v = sum w v_i plus the share `flip` of the velocity that the grid smoothed away, without C.
enum class Transfer : uint8_t { kApic, kBlend, kRpic, kFlip };

struct TransferOptions {
  Transfer kind = Transfer::kApic;
  double blend_time = 0.01;  ///< of kBlend [s]
  double flip = 0.99;        ///< of kFlip [-]
};

struct MpmScene {
  int dimension = 3;  ///< 2: the plane z = 0, laws in the plane
  double h = 0.01;    ///< grid spacing [m]; nodes are at the multiples of h
  Vec3 gravity = {};  ///< [m/s^2]
  std::vector<Solid> solids;
  std::vector<Obstacle> obstacles;
  double dt = 1e-3;  ///< from one transfer to the next [s]
  TransferOptions transfer = {};
};

/// Speed of pressure waves, sqrt((lambda + 2 mu)/rho) [m/s].
double wave_speed(const Material& material);

/// @throws Error naming what is out of range.
void check_scene(const MpmScene& scene);

}  // namespace elastogen::mpm
