// SPDX-License-Identifier: Apache-2.0
// What the particle integrators are given.

#pragma once

#include "mpm_fem/mpm/particles.hpp"
#include "mpm_fem/mpm/walls.hpp"

#include <vector>

namespace elastogen::mpm {

/// How particles get their velocity from the nodes, v_i after a step and v_i^n before it. kApic:
/// v = sum w v_i with the affine part C = 4/h^2 sum w v_i (x_i - x)^T (Jiang et al. 2015). kBlend:
/// of both parts what the grid smoothed away comes back, with the share 1 - dt/blend_time, so that
/// the smoothing does not depend on the step. kRpic: of C the antisymmetric part only. kFlip: the
/// change of the nodes' velocity, with `flip` of the particles' own.
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
  std::vector<Wall> walls;
  double dt = 1e-3;  ///< from transfer to transfer [s]
  TransferOptions transfer = {};
};

/// Speed of pressure waves, sqrt((lambda + 2 mu)/rho) [m/s].
double wave_speed(const Material& material);

/// @throws Error naming what is out of range.
void check_scene(const MpmScene& scene);

}  // namespace elastogen::mpm
