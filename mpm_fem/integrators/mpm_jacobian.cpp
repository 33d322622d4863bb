// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/mpm_jacobian.hpp"

#include <algorithm>

namespace elastogen::mpm {
namespace {

template <int d>
constexpr int kNodes = d == 3 ? 27 : 9;  // of a cell

/// Adds G^T D G of a particle to K, row-major (3 n, 3 n).
template <int d>
void add_particle(const Spline<d>& s, const double* D, double* K) {
  constexpr int n = kNodes<d>;
  double g[n][3];
  for_nodes<d, 3>(s, 0, [&](int at, double, const double slope[3], const double*) {
    for (int a = 0; a < 3; ++a) g[at][a] = slope[a];
  });
  for (int a = 0; a < n; ++a) {
    double T[3][9] = {};  // g_a D
    for (int i = 0; i < d; ++i)
      for (int k = 0; k < d; ++k)
        for (int l = 0; l < 9; ++l) T[i][l] += g[a][k] * D[9 * (3 * i + k) + l];
    for (int b = 0; b < n; ++b)
      for (int i = 0; i < d; ++i)
        for (int j = 0; j < d; ++j)
          K[(3 * a + i) * 3 * n + 3 * b + j] +=
              T[i][3 * j] * g[b][0] + T[i][3 * j + 1] * g[b][1] + T[i][3 * j + 2] * g[b][2];
  }
}

}  // namespace

template <int d>
void CellAssembly<d>::update(const ParticleGrid<d>& grid) {
  constexpr int w = ParticleGrid<d>::kTileWidth;
  fem::Stencils cells;
  first_.clear();
  for (int64_t b = 0; b < grid.blocks(); ++b) {
    int last = -1;
    for (int64_t k = grid.first_pack(b); k < grid.first_pack(b + 1); ++k) {
      const int place = grid.packs()[size_t(k)].place;
      if (place == last) continue;
      last = place;
      first_.push_back(k);
      int32_t nodes[kNodes<d>];
      for (int n = 0; n < kNodes<d>; ++n)
        nodes[n] = grid.tile(b)[place + n % 3 + w * (n / 3 % 3 + w * (n / 9))];
      cells.add(nodes, kNodes<d>);
    }
  }
  first_.push_back(int64_t(grid.packs().size()));
  if (cells == assembly_.stencils() && pattern_.rows() == 3 * grid.nodes()) return;
  ++version_;
  pattern_ = fem::pattern_of(cells, grid.nodes());
  assembly_ = fem::Assembly(std::move(cells), grid.nodes());
  assembly_.fit(pattern_);
}

template <int d>
void CellAssembly<d>::add(const ParticleGrid<d>& grid,
                          const std::function<void(int64_t, Eight*)>& tangent,
                          fem::SparseMatrix& H) const {
  assembly_.add(
      [&](int64_t cell, double* K) {
        std::fill(K, K + 9 * kNodes<d> * kNodes<d>, 0.0);
        for (int64_t k = first_[size_t(cell)]; k < first_[size_t(cell) + 1]; ++k) {
          const CellPack& pack = grid.packs()[size_t(k)];
          Eight D[81];
          tangent(k, D);
          for (int lane = 0; lane < pack.count; ++lane) {
            double own[81];
            for (int e = 0; e < 81; ++e) own[e] = D[e][lane];
            const double x[3] = {pack.x[0][lane], pack.x[1][lane], pack.x[2][lane]};
            add_particle<d>(spline<d, double>(x, pack.base, grid.h()), own, K);
          }
        }
      },
      H);
}

template class CellAssembly<2>;
template class CellAssembly<3>;

}  // namespace elastogen::mpm
