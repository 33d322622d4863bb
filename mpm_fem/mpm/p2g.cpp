// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/p2g.hpp"

#include "core/reduce.hpp"
#include "mpm_fem/mpm/lanes.hpp"

namespace elastogen::mpm {

namespace {

/// Adds momentum, with the impulse -dt V tau grad w, and mass of a pack to its nodes: with
/// u_b = m C_b w (x_i - x)_b - dt V tau_b w' along axis b, axis after axis
///
///     m v w_i w_j w_k + u_x,i w_j w_k + w_i u_y,j w_k + w_i w_j u_z,k.
template <int d, class T>
void add_pack(const ParticleGrid<d>& grid, const CellPack& pack, const Particles& p, double dt,
              double* tile) {
  constexpr int kStress[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}}, kPlanes = d == 3 ? 3 : 1;
  T x[3];
  for (int a = 0; a < 3; ++a) x[a] = load<double, T>(pack.x[a]);
  const Spline<d, T> s = spline<d>(x, pack.base, grid.h());
  const T m = counted_lanes<T>(p.mass, pack, 0);
  T v[d], u[d][d][3], impulse[6] = {};
  // impulse of the stress
  if (dt != 0) {
    const T volume = -dt * counted_lanes<T>(p.volume, pack, 0);
    for (int e = 0; e < 6; ++e) impulse[e] = volume * row_lanes<T>(p.stress, pack, e);
  }
  for (int a = 0; a < d; ++a) v[a] = m * row_lanes<T>(p.v, pack, a);
  for (int a = 0; a < d; ++a)
    for (int b = 0; b < d; ++b) {
      const T slope = m * row_lanes<T>(p.C, pack, 3 * a + b);
      for (int i = 0; i < 3; ++i)
        u[a][b][i] = slope * (s.w[b][i] * s.r[b][i]) + impulse[kStress[a][b]] * s.g[b][i];
    }
  // axis by axis into momentum and mass of the nodes
  for (int k = 0; k < kPlanes; ++k) {
    T plane[3];
    for (int a = 0; a < d; ++a) plane[a] = d == 3 ? v[a] * s.w[d - 1][k] + u[a][d - 1][k] : v[a];
    const T wk = d == 3 ? s.w[d - 1][k] : constant<T>(1);
    for (int j = 0; j < 3; ++j) {
      const T wjk = s.w[1][j] * wk, mass = m * wjk;
      T row[3];
      for (int a = 0; a < d; ++a) row[a] = plane[a] * s.w[1][j] + u[a][1][j] * wk;
      for (int i = 0; i < 3; ++i) {
        T sum[3] = {};
        for (int a = 0; a < d; ++a) sum[a] = row[a] * s.w[0][i] + u[a][0][i] * wjk;
        constexpr int kWidth = ParticleGrid<d>::kTileWidth;
        add_sums(sum[0], sum[1], sum[2], T(mass * s.w[0][i]),
                 tile + kFour * (pack.place + i + kWidth * (j + kWidth * k)));
      }
    }
  }
}

}  // namespace

template <int d>
NodeMotion particles_to_grid(const ParticleGrid<d>& grid, const Particles& p,
                             Zeroed<double>& scratch, double dt) {
  Array<double> sums(grid.nodes(), kFour);  // momentum and mass
  // sums over the particles, tile by tile
  add_tiles<d, kFour>(grid, scratch, sums, [&](int64_t b, double* tile) {
    for (int64_t k = grid.first_pack(b); k < grid.first_pack(b + 1); ++k) {
      const CellPack& pack = grid.packs()[size_t(k)];
      fetch_ahead(grid, size_t(k) + 1, p.v, p.C, p.mass);
      if (dt != 0) fetch_ahead(grid, size_t(k) + 1, p.stress, p.volume);
      pack.count > kFour ? add_pack<d, Eight>(grid, pack, p, dt, tile)
                         : add_pack<d, HalfPack>(grid, pack, p, dt, tile);
    }
  });
  // nodes with next to no mass do not move
  const double total = ordered_sum(p.count(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t k = begin; k < end; ++k) sum += p.mass(k);
    return sum;
  });
  const double least = 1e-12 * total / double(std::max<int64_t>(1, p.count()));
  NodeMotion nodes{Array<double>(grid.nodes(), 1), Array<double>(grid.nodes(), 3)};
  for_each(grid.nodes(), [&](int64_t i) {
    if (!(sums(i, 3) > least)) return;
    nodes.mass(i) = sums(i, 3);
    for (int a = 0; a < d; ++a) nodes.velocity(i, a) = sums(i, a) / sums(i, 3);
  });
  return nodes;
}

template NodeMotion particles_to_grid(const ParticleGrid<2>&, const Particles&, Zeroed<double>&,
                                      double);
template NodeMotion particles_to_grid(const ParticleGrid<3>&, const Particles&, Zeroed<double>&,
                                      double);

}  // namespace elastogen::mpm
