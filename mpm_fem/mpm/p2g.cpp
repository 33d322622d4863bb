// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/p2g.hpp"

#include "core/reduce.hpp"

namespace elastogen::mpm {

template <int d>
NodeMotion particles_to_grid(const ParticleGrid<d>& grid, const Particles& p,
                             Zeroed<double>& scratch) {
  constexpr int kWidth = ParticleGrid<d>::kTileWidth;
  Array<double> sums(grid.nodes(), kFour);  // momentum and mass
  scatter<d>(grid, p.x, scratch, sums, [&](int32_t k, const Spline<d>& s, int place, double* tile) {
    const double m = p.mass(k), *v = p.v.row(k), *C = p.C.row(k);
    const Four here = {m * v[0], m * v[1], m * v[2], m};
    const Four slope[3] = {m * column(C, 0), m * column(C, 1), m * column(C, 2)};
    for_nodes<d, kWidth>(s, place, [&](int at, double w, const double*, const double r[3]) {
      Four sum = here;
      for (int b = 0; b < d; ++b) sum += slope[b] * r[b];
      add_four(w * sum, tile + kFour * at);
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
