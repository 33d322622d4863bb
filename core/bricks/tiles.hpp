// SPDX-License-Identifier: Apache-2.0
// Sums at the nodes of voxels, brick by brick: a brick of 8x8x8 voxels gathers the values of its
// 9x9x9 nodes into a tile, its own and a halo of one node at the upper sides, works there, and
// gives each node its sum.
//
// Nodes on the faces between bricks get one partial sum from each brick; these are added in the
// order of the bricks, so every run gives the same bits on any number of threads.

#pragma once

#include "core/parallel.hpp"
#include "core/voxel_grid.hpp"
#include "core/zeroed.hpp"

#include <vector>

namespace elastogen {

namespace bricks {

inline constexpr int kTileWidth = 9;                    ///< nodes of a tile along an axis
inline constexpr int kLines = kTileWidth * kTileWidth;  ///< lines of nodes along x in a tile
inline constexpr int kTile = kLines * kTileWidth;       ///< nodes of a tile

}  // namespace bricks

/// The nodes of each brick, with their places in its tile, x + 9 (y + 9 z).
struct BrickTiles {
  std::vector<int32_t> tile_begin;    ///< first tile entry of each brick, (bricks + 1)
  Zeroed<int32_t> tile_node;          ///< node of a tile entry
  Zeroed<int16_t> tile_place;         ///< its place in the tile
  Zeroed<int32_t> tile_part;          ///< -1: this brick alone holds the node; else its partial sum
  std::vector<int32_t> shared_node;   ///< nodes of several bricks
  std::vector<int32_t> shared_begin;  ///< first partial sum of each, (shared + 1)

  int64_t brick_count() const { return int64_t(tile_begin.size()) - 1; }
  int64_t part_count() const { return shared_begin.empty() ? 0 : shared_begin.back(); }
};

/// First voxel of each brick of a grid.
std::vector<int32_t> first_voxels(const VoxelGrid& grid);

/// Needs only coordinates and tables of the grid.
/// @param first  first_voxels of the grid.
BrickTiles make_brick_tiles(const VoxelGrid& grid, const std::vector<int32_t>& first);

/// Partial sums of shared nodes; kept between calls so that a step allocates nothing.
template <class T>
struct BrickScratch {
  Zeroed<T> parts;
  explicit BrickScratch(const BrickTiles& g) : parts(3 * size_t(g.part_count())) {}
};

/// Calls put(place, value) for the nodes of a brick; read(node, reference, value) fills the three
/// values of a node, reference the first node of the brick.
template <class T, class Read, class Put>
void read_tile(const BrickTiles& g, int64_t brick, const Read& read, const Put& put) {
  const int32_t begin = g.tile_begin[size_t(brick)], end = g.tile_begin[size_t(brick + 1)];
  for (int32_t k = begin; k < end; ++k) {
    T value[3];
    read(g.tile_node[size_t(k)], g.tile_node[size_t(begin)], value);
    put(g.tile_place[size_t(k)], value);
  }
}

/// Calls finish(node, sum) for the nodes that this brick alone holds; the sums of others become
/// their partial sums. sum_at(place, sum) gives the sum at a place.
template <class T, class SumAt, class Finish>
void finish_tile(const BrickTiles& g, int64_t brick, const SumAt& sum_at, BrickScratch<T>& scratch,
                 const Finish& finish) {
  const int32_t end = g.tile_begin[size_t(brick + 1)];
  for (int32_t k = g.tile_begin[size_t(brick)]; k < end; ++k) {
    T sum[3];
    sum_at(g.tile_place[size_t(k)], sum);
    const int32_t part = g.tile_part[size_t(k)];
    if (part < 0) {
      finish(g.tile_node[size_t(k)], sum);
    } else {
      for (int i = 0; i < 3; ++i) scratch.parts[3 * size_t(part) + size_t(i)] = sum[i];
    }
  }
}

/// Calls finish(node, sum) for the nodes that several bricks hold; all bricks must be finished.
template <class T, class Finish>
void finish_shared(const BrickTiles& g, const BrickScratch<T>& scratch, const Finish& finish) {
  for_each(int64_t(g.shared_node.size()), [&](int64_t s) {
    T sum[3] = {};
    for (int32_t p = g.shared_begin[size_t(s)]; p < g.shared_begin[size_t(s + 1)]; ++p)
      for (int i = 0; i < 3; ++i) sum[i] += scratch.parts[3 * size_t(p) + size_t(i)];
    finish(g.shared_node[size_t(s)], sum);
  });
}

}  // namespace elastogen
