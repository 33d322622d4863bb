// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/p2g.hpp"

#include "core/reduce.hpp"
#include "mpm_fem/mpm/lanes.hpp"

namespace elastogen::mpm {

template <int d>
NodeMotion particles_to_grid(const ParticleGrid<d>& grid, const Particles& p,
                             Zeroed<double>& scratch) {
  Array<double> sums(grid.nodes(), kFour);  // momentum and mass
  add_tiles<d, kFour>(grid, scratch, sums, [&](int64_t b, double* tile) {
    for_packs<d>(grid, b, [&](int64_t k, const PackSpline<d>& s) {
      const CellPack& pack = grid.packs()[size_t(k)];
      const Eight m = counted_lanes(p.mass, pack, 0);
      Eight here[3] = {}, slope[d][d];
      for (int a = 0; a < d; ++a) here[a] = m * row_lanes(p.v, pack, a);
      for (int a = 0; a < d; ++a)
        for (int c = 0; c < d; ++c) slope[a][c] = m * row_lanes(p.C, pack, 3 * a + c);
      for_pack_nodes<d>(grid, k, s, [&](int at, const Eight& w, const Eight*, const Eight away[3]) {
        Eight momentum[3] = {};
        for (int a = 0; a < d; ++a) {
          momentum[a] = here[a];
          for (int c = 0; c < d; ++c) momentum[a] += slope[a][c] * away[c];
          momentum[a] *= w;
        }
        add_sums(momentum[0], momentum[1], momentum[2], m * w, tile + kFour * at);
      });
    });
  });
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

template NodeMotion particles_to_grid(const ParticleGrid<2>&, const Particles&, Zeroed<double>&);
template NodeMotion particles_to_grid(const ParticleGrid<3>&, const Particles&, Zeroed<double>&);

}  // namespace elastogen::mpm
