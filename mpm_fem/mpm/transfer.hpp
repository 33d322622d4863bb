// SPDX-License-Identifier: Apache-2.0
// Sums of particles into nodes and of nodes into particles, tile by tile and pack by pack in a tile
// (particle_grid.hpp).

#pragma once

#include "core/mat3.hpp"
#include "core/parallel.hpp"
#include "core/zeroed.hpp"
#include "mpm_fem/mpm/particle_grid.hpp"
#include "mpm_fem/mpm/spline.hpp"

#include <cstring>

namespace elastogen::mpm {

/// One number for each particle of a pack.
using Eight = Pack<double>;
template <int d>
using PackSpline = Spline<d, Eight>;

/// Three components of a node, and one more number.
using Four = HalfPack;
inline constexpr int kFour = 4;

/// Adds the sums over the particles of four packs, or of their first halves, to four numbers.
template <class T>
void add_sums(const T& a, const T& b, const T& c, const T& d, double* to) {
  const auto halves = [](const T& v) {
    if constexpr (lane_count<T> == kFour)
      return v;
    else
      return Four(__builtin_shufflevector(v, v, 0, 1, 2, 3)) +
             Four(__builtin_shufflevector(v, v, 4, 5, 6, 7));
  };
  const auto pairs = [](const Four& v, const Four& w) {  // v0 + v1, w0 + w1, v2 + v3, w2 + w3
    return Four(__builtin_shufflevector(v, w, 0, 4, 2, 6)) +
           Four(__builtin_shufflevector(v, w, 1, 5, 3, 7));
  };
  const Four ab = pairs(halves(a), halves(b)), cd = pairs(halves(c), halves(d));
  Four sum;
  std::memcpy(&sum, to, sizeof sum);
  sum += Four(__builtin_shufflevector(ab, cd, 0, 1, 4, 5)) +
         Four(__builtin_shufflevector(ab, cd, 2, 3, 6, 7));
  std::memcpy(to, &sum, sizeof sum);
}

/// Calls visit(pack, spline) for the packs of a block; `pack` is the index into grid.packs().
template <int d, class Visit>
void for_packs(const ParticleGrid<d>& g, int64_t b, const Visit& visit) {
  for (int64_t k = g.first_pack(b); k < g.first_pack(b + 1); ++k) {
    const CellPack& pack = g.packs()[size_t(k)];
    const Eight x[3] = {load(pack.x[0]), load(pack.x[1]), load(pack.x[2])};
    visit(k, spline<d>(x, pack.base, g.h()));
  }
}

/// Calls visit(at, w, g, r) for the nodes of a pack as for_nodes; `at` is their place in the tile.
template <int d, class Visit>
void for_pack_nodes(const ParticleGrid<d>& g, int64_t pack, const PackSpline<d>& s,
                    const Visit& visit) {
  for_nodes<d, ParticleGrid<d>::kTileWidth>(s, g.packs()[size_t(pack)].place, visit);
}

/// Reads the values of the nodes of a block's tile, (kTile, 4). The fourth number is 0, and all are
/// 0 where there is no node.
template <int d>
void read_tile(const ParticleGrid<d>& g, int64_t b, In<double> nodes, double* tile) {
  const int32_t* node = g.tile(b);
  for (int t = 0; t < ParticleGrid<d>::kTile; ++t)
    for (int a = 0; a < kFour; ++a)
      tile[kFour * t + a] = node[t] < 0 || a == 3 ? 0 : nodes(node[t], a);
}

/// Sums over all particles at the nodes. fill(block, tile) writes the sums of a block's particles,
/// (kTile, K), into zeros; nodes add those of their tiles.
/// @param nodes  (nodes, K), or fewer columns for the first of the K numbers
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

/// Calls add(pack, spline, read, write) for each pack. read[4 at + component] has the values of the
/// nodes; add adds four numbers to nodes in write[4 at + k].
/// @param from  (nodes, 3)
/// @param to    (nodes, 4), or fewer columns for the first of the four
template <int d, class Add>
void gather_scatter(const ParticleGrid<d>& g, In<double> from, Zeroed<double>& scratch,
                    Out<double> to, const Add& add) {
  add_tiles<d, kFour>(g, scratch, to, [&](int64_t b, double* write) {
    alignas(64) double read[kFour * ParticleGrid<d>::kTile];
    read_tile(g, b, from, read);
    for_packs<d>(g, b, [&](int64_t pack, const PackSpline<d>& s) { add(pack, s, read, write); });
  });
}

/// Calls take(pack, spline, tile) for each pack; tile[4 at + component] has the values of the
/// nodes.
/// @param nodes  (nodes, 3)
template <int d, class Take>
void gather(const ParticleGrid<d>& g, In<double> nodes, const Take& take) {
  run_tasks(g.blocks(), [&](int64_t b) {
    alignas(64) double tile[kFour * ParticleGrid<d>::kTile];
    read_tile(g, b, nodes, tile);
    for_packs<d>(g, b, [&](int64_t pack, const PackSpline<d>& s) { take(pack, s, tile); });
  });
}

/// sum_i a_i (x) dw_i/dx, row-major.
template <int d>
Mat3<Eight> nodal_gradient(const ParticleGrid<d>& grid, int64_t pack, const PackSpline<d>& s,
                           const double* tile) {
  Mat3<Eight> G = {};
  for_pack_nodes<d>(grid, pack, s, [&](int at, const Eight&, const Eight g[3], const Eight*) {
    for (int a = 0; a < d; ++a)
      for (int b = 0; b < d; ++b) G(a, b) += tile[kFour * at + a] * g[b];
  });
  return G;
}

/// Adds A dw_i/dx to each node.
template <int d>
void add_nodal_product(const ParticleGrid<d>& grid, int64_t pack, const PackSpline<d>& s,
                       const Mat3<Eight>& A, double* tile) {
  for_pack_nodes<d>(grid, pack, s, [&](int at, const Eight&, const Eight g[3], const Eight*) {
    Eight f[3] = {};
    for (int a = 0; a < d; ++a)
      for (int b = 0; b < d; ++b) f[a] += A(a, b) * g[b];
    add_sums(f[0], f[1], f[2], Eight{}, tile + kFour * at);
  });
}

}  // namespace elastogen::mpm
