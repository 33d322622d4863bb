// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/g2p.hpp"

#include <algorithm>

namespace elastogen::mpm {
template <int d, class T>
void transfer_velocities(const TransferOptions& transfer, double dt, const CellPack& pack,
                         int begin, const FieldPack<T>& now, const FieldPack<T>& before,
                         Particles& p) {
  const double back = transfer.kind == Transfer::kBlend
                          ? std::max(0.0, 1 - dt / transfer.blend_time)
                          : transfer.flip;
  FieldPack<T> end = now;
  if (looks_back(transfer))
    for (int a = 0; a < d; ++a)
      end.v[a] += back * (row_lanes<T>(p.v, pack, a, begin) - before.v[a]);
  if (transfer.kind == Transfer::kFlip) end.C = {};
  for (int a = 0; a < d; ++a)
    for (int b = 0; b < d; ++b) {
      if (transfer.kind == Transfer::kRpic) end.C(a, b) = (now.C(a, b) - now.C(b, a)) / 2;
      if (transfer.kind == Transfer::kBlend)
        end.C(a, b) += back * (row_lanes<T>(p.C, pack, 3 * a + b, begin) - before.C(a, b));
    }
  for (int lane = 0; lane < std::min(lane_count<T>, pack.count - begin); ++lane) {
    const int32_t k = pack.particle[begin + lane];
    for (int a = 0; a < 3; ++a) p.v(k, a) = end.v[a][lane];
    for (int e = 0; e < 9; ++e) p.C(k, e) = end.C.m[e][lane];
  }
}

template <int d>
void grid_to_particles(const ParticleGrid<d>& grid, In<double> motion, In<double> before,
                       In<double> after, const TransferOptions& transfer, double dt, Particles& p) {
  grid_to_particles<d>(grid, motion, before, after, transfer, dt, p,
                       [](int64_t, int, const Mat3<WidePack>&) {});
}

template void transfer_velocities<2>(const TransferOptions&, double, const CellPack&, int,
                                     const FieldPack<WidePack>&, const FieldPack<WidePack>&,
                                     Particles&);
template void transfer_velocities<3>(const TransferOptions&, double, const CellPack&, int,
                                     const FieldPack<WidePack>&, const FieldPack<WidePack>&,
                                     Particles&);
template void grid_to_particles(const ParticleGrid<2>&, In<double>, In<double>, In<double>,
                                const TransferOptions&, double, Particles&);
template void grid_to_particles(const ParticleGrid<3>&, In<double>, In<double>, In<double>,
                                const TransferOptions&, double, Particles&);

}  // namespace elastogen::mpm
