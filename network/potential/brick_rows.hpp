// SPDX-License-Identifier: Apache-2.0
// The loop that all operations on voxels share. It runs over the tile of each brick
// (core/bricks/tiles.hpp), in rows of eight voxels along x.

#pragma once

#include "core/bricks/tiles.hpp"
#include "core/pack.hpp"
#include "core/scene.hpp"

#include <cstring>
#include <vector>

namespace elastogen {

/// Eight neighbouring voxels of one material; lanes without a voxel have weight 0 everywhere.
struct VoxelRow {
  int32_t offset = 0;    ///< tile position of the first voxel's corner 0, x + 9 (y + 9 z)
  int32_t material = 0;  ///< index into Scene::materials
  int32_t border = -1;   ///< index into border data, -1 where all voxels are full
  uint32_t mask = 0;     ///< bit l: lane l holds a voxel

  bool operator==(const VoxelRow&) const = default;
};

/// Rows and tiles of a grid. The slot of a voxel is kLanes * row + lane; voxel data are stored as
/// [row][field][lane].
struct BrickRows : BrickTiles {
  Zeroed<VoxelRow> rows;
  std::vector<int32_t> row_begin;  ///< first row of each brick, (bricks + 1)
  Zeroed<int32_t> slot;            ///< slot of each voxel
  Zeroed<int32_t> voxel;           ///< voxel of each slot, -1 if none
  Zeroed<double> border;  ///< moments M_0 ... M_6 of the rows with border voxels, [border][7][8]

  int64_t row_count() const { return int64_t(rows.size()); }
};

/// Whether the shape means of a voxel are all 1/8; without shape means all voxels are full.
inline bool is_full(const VoxelGrid& grid, int64_t v) {
  if (grid.shape_mean.empty()) return true;
  for (int c = 0; c < 8; ++c)
    if (grid.shape_mean(v, c) != 0.125) return false;
  return true;
}

/// Builds rows and tiles. A row has voxels of one material of `material`, (voxels); rows with
/// voxels that are not full get border data. Only coordinates and tables of the grid are read.
BrickRows make_brick_rows(const VoxelGrid& grid, In<int32_t> material);
BrickRows make_brick_rows(const Scene& scene);

namespace bricks {

/// Working data of one brick, on the stack of its task.
template <class T>
struct Tile {
  T in[3][kTile + 7];
  alignas(64) T out[2][3][kLines][kLanes];  ///< sums of corners with x = 0 and x = 1
};

template <class T>
void read_row(const Tile<T>& tile, int offset, Pack<T> u[3][8]) {
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 8; ++c)
      u[i][c] = load(&tile.in[i][offset + (c & 1) + (c & 2 ? 9 : 0) + (c & 4 ? 81 : 0)]);
}

template <class T>
void add_row(Tile<T>& tile, int offset, const Pack<T> f[3][8]) {
  const int line = offset / kTileWidth;
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 8; ++c) {
      T* place = tile.out[c & 1][i][line + (c & 2 ? 1 : 0) + (c & 4 ? 9 : 0)];
      store<T>(place, load(place) + f[i][c]);
    }
}

template <class T>
void node_sum(const Tile<T>& tile, int place, T sum[3]) {
  const int line = place / kTileWidth, x = place % kTileWidth;
  for (int i = 0; i < 3; ++i) {
    sum[i] = x < kLanes ? tile.out[0][i][line][x] : T(0);
    if (x > 0) sum[i] += tile.out[1][i][line][x - 1];
  }
}

}  // namespace bricks

/// Runs `row(r, u, f, sums)` on every row: u are the values at the corners (component, corner), f
/// what the row adds to them, summed over the voxels of each node. `read(node, reference, value)`
/// fills the three values of a node (reference is the first node of the brick), and `finish(node,
/// sum)` is called once for each node with its sum. `sums` gets each brick's Sums, in order.
template <class T, class Sums, class Read, class RowKernel, class Finish>
void for_each_row(const BrickRows& g, BrickScratch<T>& scratch, std::vector<Sums>& sums,
                  const Read& read, const RowKernel& row, const Finish& finish) {
  sums.assign(size_t(g.brick_count()), Sums{});
  run_tasks(g.brick_count(), [&](int64_t b) {
    bricks::Tile<T> tile;
    std::memset(&tile, 0, sizeof tile);
    read_tile<T>(g, b, read, [&](int place, const T value[3]) {
      for (int i = 0; i < 3; ++i) tile.in[i][place] = value[i];
    });
    for (int32_t r = g.row_begin[size_t(b)]; r < g.row_begin[size_t(b + 1)]; ++r) {
      Pack<T> u[3][8], f[3][8];
      bricks::read_row(tile, g.rows[size_t(r)].offset, u);
      row(r, u, f, sums[size_t(b)]);
      bricks::add_row(tile, g.rows[size_t(r)].offset, f);
    }
    finish_tile(
        g, b, [&](int place, T sum[3]) { bricks::node_sum(tile, place, sum); }, scratch, finish);
  });
  finish_shared(g, scratch, finish);
}

/// For kernels that sum nothing but forces.
struct NoSums {};

}  // namespace elastogen
