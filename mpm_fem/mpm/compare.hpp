// SPDX-License-Identifier: Apache-2.0
// Likeness of two clouds of particles, by the mass that both bring to the nodes of one grid. With
// A_i and B_i the masses of node i
//
//     iou_weighted = sum min(A, B) / sum max(A, B),
//     iou_binary   = nodes with more than a tenth of a full node's mass in both / in one of them,
//     iou_soft     = I/(U - I),  I = sum A B/(max A max B),  U = sum A/max A + B/max B.
//
// The first two are 1 for equal clouds. The third, which PlasticityNet (Li et al. 2022) cites from
// Huang et al. 2021, is not. So it is also given over the root of its values for each cloud with
// itself.

#pragma once

#include "mpm_fem/mpm/particles.hpp"

namespace elastogen::mpm {

struct Likeness {
  double iou_weighted = 1, iou_binary = 1, iou_soft = 1;
  double iou_soft_scaled = 1;  ///< iou_soft(A, B) / sqrt(iou_soft(A, A) iou_soft(B, B))
};

/// @param dimension  2 or 3
/// @param h          spacing of the grid [m]
/// @param full       mass of a node within the body, rho h^d [kg]
/// @throws Error (resources) as ParticleGrid::update
Likeness compare(const Particles& a, const Particles& b, int dimension, double h, double full);

}  // namespace elastogen::mpm
