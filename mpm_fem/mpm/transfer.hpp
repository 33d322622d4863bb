// SPDX-License-Identifier: Apache-2.0
// Sums of particles into nodes and of nodes into particles, tile by tile (particle_grid.hpp).

#pragma once

#include "core/mat3.hpp"
#include "core/parallel.hpp"
#include "core/zeroed.hpp"
#include "mpm_fem/mpm/particle_grid.hpp"
#include "mpm_fem/mpm/spline.hpp"

#include <cstring>

namespace elastogen::mpm {

/// Three components of a node, and one more number, worked on at once.
typedef double Four __attribute__((vector_size(32)));
inline constexpr int kFour = 4;

inline Four load_four(const double* from) {
  Four value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
inline void add_four(const Four& value, double* to) {
  const Four sum = load_four(to) + value;
  std::memcpy(to, &sum, sizeof sum);
}
/// Column b of a matrix.
inline Four column(const double* A, int b) {
  return Four{A[b], A[3 + b], A[6 + b], 0};
}

/// Place in its block's tile of the first node that a spline touches.
template <int d>
int tile_place(const std::array<int32_t, 3>& corner, const Spline<d>& s) {
  constexpr int w = ParticleGrid<d>::kTileWidth;
  return s.base[0] - corner[0] + w * (s.base[1] - corner[1] + w * (s.base[2] - corner[2]));
}

/// visit(particle, spline, place) for the particles of a block.
template <int d, class Visit>
void for_particles(const ParticleGrid<d>& g, In<double> x, int64_t b, const Visit& visit) {
  const std::array<int32_t, 3> corner = g.corner(b);
  for (int64_t k = g.first(b); k < g.first(b + 1); ++k) {
    const int32_t p = g.order()[size_t(k)];
    const Spline<d> s = spline<d>(x.row(p), g.h());
    visit(p, s, tile_place(corner, s));
  }
}

/// Values of the nodes of a block's tile, (kTile, 4), the last 0; all 0 where there is none.
template <int d>
void read_tile(const ParticleGrid<d>& g, int64_t b, In<double> nodes, double* tile) {
  const int32_t* node = g.tile(b);
  for (int t = 0; t < ParticleGrid<d>::kTile; ++t)
    for (int a = 0; a < kFour; ++a)
      tile[kFour * t + a] = node[t] < 0 || a == 3 ? 0 : nodes(node[t], a);
}

/// fill(block, tile) writes the sums of a block's particles, (kTile, K), into zeros; nodes get
/// those of their tiles.
/// @param nodes  (nodes, K), or of the K numbers the first ones
template <int d, int K, class Fill>
void add_tiles(const ParticleGrid<d>& g, Zeroed<double>& scratch, Out<double> nodes,
               const Fill& fill) {
  constexpr int kSize = ParticleGrid<d>::kTile * K;
  if (int64_t(scratch.size()) < g.blocks() * kSize) scratch.resize(size_t(g.blocks() * kSize));
  run_tasks(g.blocks(), [&](int64_t b) {
    double* tile = scratch.data() + b * kSize;
    std::memset(tile, 0, sizeof(double) * kSize);
    fill(b, tile);
  });
  for_each(g.nodes(), [&](int64_t i) {
    double sum[K] = {};
    for (const int64_t* s = g.sources_begin(i); s != g.sources_end(i); ++s)
      for (int k = 0; k < K; ++k) sum[k] += scratch[size_t(*s * K + k)];
    for (int k = 0; k < nodes.cols; ++k) nodes(i, k) = sum[k];
  });
}

/// add(particle, spline, place, tile) for each particle, which adds four numbers to each of its
/// nodes, tile[4 place + k]; nodes get their sums.
/// @param nodes  (nodes, 4), or of the four the first ones
template <int d, class Add>
void scatter(const ParticleGrid<d>& g, In<double> x, Zeroed<double>& scratch, Out<double> nodes,
             const Add& add) {
  add_tiles<d, kFour>(g, scratch, nodes, [&](int64_t b, double* tile) {
    for_particles<d>(g, x, b,
                     [&](int32_t p, const Spline<d>& s, int place) { add(p, s, place, tile); });
  });
}

/// add(particle, spline, place, read, write) for each particle, with the values of its nodes in
/// read[4 place + component], which adds numbers to each in write[4 place + component].
/// @param from, to  (nodes, 3)
template <int d, class Add>
void gather_scatter(const ParticleGrid<d>& g, In<double> x, In<double> from,
                    Zeroed<double>& scratch, Out<double> to, const Add& add) {
  add_tiles<d, kFour>(g, scratch, to, [&](int64_t b, double* write) {
    double read[kFour * ParticleGrid<d>::kTile];
    read_tile(g, b, from, read);
    for_particles<d>(
        g, x, b, [&](int32_t p, const Spline<d>& s, int place) { add(p, s, place, read, write); });
  });
}

/// take(particle, spline, place, tile) for each particle, with the values of its nodes in
/// tile[4 place + component].
/// @param nodes  (nodes, 3)
template <int d, class Take>
void gather(const ParticleGrid<d>& g, In<double> x, In<double> nodes, const Take& take) {
  run_tasks(g.blocks(), [&](int64_t b) {
    double tile[kFour * ParticleGrid<d>::kTile];
    read_tile(g, b, nodes, tile);
    for_particles<d>(g, x, b,
                     [&](int32_t p, const Spline<d>& s, int place) { take(p, s, place, tile); });
  });
}

/// sum_i a_i (x) dw_i/dx, row-major.
template <int d>
Mat3<double> nodal_gradient(const Spline<d>& s, int place, const double* tile) {
  Four sum[3] = {};
  for_nodes<d, ParticleGrid<d>::kTileWidth>(s, place,
                                            [&](int at, double, const double g[3], const double*) {
                                              const Four value = load_four(tile + kFour * at);
                                              for (int b = 0; b < d; ++b) sum[b] += value * g[b];
                                            });
  Mat3<double> G;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) G(a, b) = sum[b][a];
  return G;
}

/// Adds A dw_i/dx to each node.
template <int d>
void add_nodal_product(const Spline<d>& s, int place, const Mat3<double>& A, double* tile) {
  const Four of[3] = {column(A.m, 0), column(A.m, 1), column(A.m, 2)};
  for_nodes<d, ParticleGrid<d>::kTileWidth>(s, place,
                                            [&](int at, double, const double g[3], const double*) {
                                              Four f = of[0] * g[0];
                                              for (int b = 1; b < d; ++b) f += of[b] * g[b];
                                              add_four(f, tile + kFour * at);
                                            });
}

}  // namespace elastogen::mpm
