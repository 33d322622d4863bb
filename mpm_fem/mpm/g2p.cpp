// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/g2p.hpp"

#include <algorithm>

namespace elastogen::mpm {
namespace {

/// v = sum w v_i and C = 4/h^2 sum w v_i (x_i - x)^T.
struct Affine {
  double v[3] = {}, C[9] = {};
};

template <int d>
Affine affine(const Spline<d>& s, int place, const double* tile, double h) {
  Four v = {}, C[3] = {};
  for_nodes<d, ParticleGrid<d>::kTileWidth>(
      s, place, [&](int at, double w, const double*, const double away[3]) {
        const Four part = w * load_four(tile + kFour * at);
        v += part;
        for (int b = 0; b < d; ++b) C[b] += part * away[b];
      });
  Affine r;
  for (int a = 0; a < d; ++a) {
    r.v[a] = v[a];
    for (int b = 0; b < d; ++b) r.C[3 * a + b] = 4 / (h * h) * C[b][a];
  }
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
  const int64_t count = p.count();
  std::vector<Affine> start;
  if (transfer.kind == Transfer::kBlend || transfer.kind == Transfer::kFlip) {
    start.resize(size_t(count));
    gather<d>(grid, p.x, before, [&](int32_t k, const Spline<d>& s, int place, const double* tile) {
      start[size_t(k)] = affine<d>(s, place, tile, grid.h());
    });
  }
  gather<d>(grid, p.x, after, [&](int32_t k, const Spline<d>& s, int place, const double* tile) {
    const Affine none;
    transferred<d>(transfer, dt, affine<d>(s, place, tile, grid.h()),
                   start.empty() ? none : start[size_t(k)], p.v.row(k), p.C.row(k));
  });
  // last, since the splines stand at the places before
  Array<double> moved = p.x;
  gather<d>(grid, p.x, motion, [&](int32_t k, const Spline<d>& s, int place, const double* tile) {
    Four way = {};
    for_nodes<d, ParticleGrid<d>::kTileWidth>(s, place,
                                              [&](int at, double w, const double*, const double*) {
                                                way += w * load_four(tile + kFour * at);
                                              });
    for (int a = 0; a < d; ++a) moved(k, a) += way[a];
  });
  p.x = std::move(moved);
}

template void grid_to_particles(const ParticleGrid<2>&, In<double>, In<double>, In<double>,
                                const TransferOptions&, double, Particles&);
template void grid_to_particles(const ParticleGrid<3>&, In<double>, In<double>, In<double>,
                                const TransferOptions&, double, Particles&);

}  // namespace elastogen::mpm
