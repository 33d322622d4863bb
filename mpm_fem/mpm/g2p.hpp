// SPDX-License-Identifier: Apache-2.0
// Grid to particles: places and velocities after a step.

#pragma once

#include "mpm_fem/mpm/cell_field.hpp"
#include "mpm_fem/mpm/lanes.hpp"
#include "mpm_fem/mpm/mpm_scene.hpp"

namespace elastogen::mpm {

/// Whether a transfer needs the nodes' velocities before the step.
inline bool looks_back(const TransferOptions& transfer) {
  return transfer.kind == Transfer::kBlend || transfer.kind == Transfer::kFlip;
}

/// Sets the velocities of a pack's particles by the transfer.
/// @param now     the field of the nodes at the end of a step
/// @param before  at its start; only read if the transfer looks back
template <int d, class T>
void transfer_velocities(const TransferOptions& transfer, double dt, const CellPack& pack,
                         int begin, const FieldPack<T>& now, const FieldPack<T>& before,
                         Particles& p);

/// Moves the particles with the nodes and sets their velocities by the transfer.
/// @param motion  of the nodes in the step [m], (nodes, 3); empty: dt times `after`
/// @param before  velocities of the nodes at its start, as they came from the particles [m/s]
/// @param after   at its end [m/s]
/// @param strain  strain(pack, begin, G) gets the gradient of the motion at lanes from `begin` on
template <int d, class Strain>
void grid_to_particles(const ParticleGrid<d>& grid, In<double> motion, In<double> before,
                       In<double> after, const TransferOptions& transfer, double dt, Particles& p,
                       const Strain& strain) {
  using T = WidePack;
  constexpr int kSize = kFour * ParticleGrid<d>::kTile;
  const bool looks = looks_back(transfer), moves = motion.rows > 0;
  run_tasks(grid.blocks(), [&](int64_t b) {
    alignas(64) double moved[kSize], now[kSize], then[kSize];
    // values of the nodes around the block
    if (moves) read_tile(grid, b, motion, moved);
    read_tile(grid, b, after, now);
    if (looks) read_tile(grid, b, before, then);
    for (int64_t k = grid.first_pack(b); k < grid.first_pack(b + 1); ++k) {
      const CellPack& pack = grid.packs()[size_t(k)];
      fetch_ahead(grid, size_t(k) + 1, p.x, p.v, p.C, p.F, p.stress, p.history);
      for (int begin = 0; begin < pack.count; begin += lane_count<T>) {
        // motion of the particles, and its gradient
        const FieldPack<T> field = field_at<d, T>(grid, pack, begin, now);
        FieldPack<T> path = field;
        if (moves) {
          path = field_at<d, T>(grid, pack, begin, moved);
        } else {
          for (T& v : path.v) v *= dt;
          for (T& g : path.G.m) g *= dt;
        }
        strain(k, begin, path.G);
        // velocities, then places
        const FieldPack<T> past = looks ? field_at<d, T>(grid, pack, begin, then) : FieldPack<T>{};
        transfer_velocities<d>(transfer, dt, pack, begin, field, past, p);
        for (int lane = 0; lane < std::min(lane_count<T>, pack.count - begin); ++lane)
          for (int a = 0; a < d; ++a) p.x(pack.particle[begin + lane], a) += path.v[a][lane];
      }
    }
  });
}

/// grid_to_particles without strain.
template <int d>
void grid_to_particles(const ParticleGrid<d>& grid, In<double> motion, In<double> before,
                       In<double> after, const TransferOptions& transfer, double dt,
                       Particles& particles);

}  // namespace elastogen::mpm
