// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/g2p.hpp"

#include "mpm_fem/mpm/lanes.hpp"

#include <algorithm>

namespace elastogen::mpm {
namespace {

/// v = sum w v_i and C = 4/h^2 sum w v_i (x_i - x)^T.
struct Affine {
  double v[3] = {}, C[9] = {};
};
struct AffinePack {
  Eight v[3] = {}, C[9] = {};

  Affine lane(int lane) const {
    Affine one;
    for (int a = 0; a < 3; ++a) one.v[a] = v[a][lane];
    for (int e = 0; e < 9; ++e) one.C[e] = C[e][lane];
    return one;
  }
};

template <int d>
AffinePack affine(const ParticleGrid<d>& grid, int64_t pack, const PackSpline<d>& s,
                  const double* tile) {
  AffinePack r;
  for_pack_nodes<d>(grid, pack, s, [&](int at, const Eight& w, const Eight*, const Eight away[3]) {
    for (int a = 0; a < d; ++a) {
      const Eight part = tile[kFour * at + a] * w;
      r.v[a] += part;
      for (int b = 0; b < d; ++b) r.C[3 * a + b] += part * away[b];
    }
  });
  for (Eight& c : r.C) c *= 4 / (grid.h() * grid.h());
  return r;
}

/// The velocity of a particle that has `now` of the nodes, and `own` before the step.
template <int d>
void transferred(const TransferOptions& transfer, double dt, const Affine& now,
                 const Affine& before, double* v, double* C) {
  const double back = transfer.kind == Transfer::kBlend
                          ? std::max(0.0, 1 - dt / transfer.blend_time)
                      : transfer.kind == Transfer::kFlip ? transfer.flip
                                                         : 0;
  for (int a = 0; a < d; ++a) v[a] = now.v[a] + back * (v[a] - before.v[a]);
  for (int a = 0; a < d; ++a)
    for (int b = 0; b < d; ++b) {
      const int k = 3 * a + b, m = 3 * b + a;
      switch (transfer.kind) {
        case Transfer::kApic:
          C[k] = now.C[k];
          break;
        case Transfer::kBlend:
          C[k] = now.C[k] + back * (C[k] - before.C[k]);
          break;
        case Transfer::kRpic:
          C[k] = (now.C[k] - now.C[m]) / 2;
          break;
        case Transfer::kFlip:
          C[k] = 0;
          break;
      }
    }
}

}  // namespace

template <int d>
void grid_to_particles(const ParticleGrid<d>& grid, In<double> motion, In<double> before,
                       In<double> after, const TransferOptions& transfer, double dt, Particles& p) {
  constexpr int kSize = kFour * ParticleGrid<d>::kTile;
  const bool looks_back = transfer.kind == Transfer::kBlend || transfer.kind == Transfer::kFlip;
  run_tasks(grid.blocks(), [&](int64_t b) {
    alignas(64) double way[kSize], now[kSize], then[kSize];
    read_tile(grid, b, motion, way);
    read_tile(grid, b, after, now);
    if (looks_back) read_tile(grid, b, before, then);
    for_packs<d>(grid, b, [&](int64_t k, const PackSpline<d>& s) {
      const CellPack& pack = grid.packs()[size_t(k)];
      const AffinePack field = affine<d>(grid, k, s, now);
      const AffinePack past = looks_back ? affine<d>(grid, k, s, then) : AffinePack{};
      Eight moved[3] = {};
      for_pack_nodes<d>(grid, k, s, [&](int at, const Eight& w, const Eight*, const Eight*) {
        for (int a = 0; a < d; ++a) moved[a] += way[kFour * at + a] * w;
      });
      for (int lane = 0; lane < pack.count; ++lane) {
        const int32_t n = pack.particle[lane];
        transferred<d>(transfer, dt, field.lane(lane), past.lane(lane), p.v.row(n), p.C.row(n));
        for (int a = 0; a < d; ++a) p.x(n, a) += moved[a][lane];
      }
    });
  });
}

template void grid_to_particles(const ParticleGrid<2>&, In<double>, In<double>, In<double>,
                                const TransferOptions&, double, Particles&);
template void grid_to_particles(const ParticleGrid<3>&, In<double>, In<double>, In<double>,
                                const TransferOptions&, double, Particles&);

}  // namespace elastogen::mpm
