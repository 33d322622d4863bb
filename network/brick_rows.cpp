// SPDX-License-Identifier: Apache-2.0
#include "network/brick_rows.hpp"

#include "core/error.hpp"
#include "core/hex8.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace elastogen {
namespace {

using Coord = std::array<int32_t, 3>;

Coord brick_of(const Array<int32_t>& coord, int64_t i) {
  return {coord(i, 0) >> 3, coord(i, 1) >> 3, coord(i, 2) >> 3};
}

bool is_full(const VoxelGrid& grid, int64_t v) {
  for (int c = 0; c < 8; ++c)
    if (grid.shape_mean(v, c) != 0.125) return false;
  return true;
}

/// Rows of one brick: voxels of one line and material.
void add_rows(const VoxelGrid& grid, In<int32_t> material, int64_t begin, int64_t end,
              BrickRows& g) {
  using Key = std::tuple<int32_t, int32_t>;  // offset, material
  std::vector<std::pair<Key, int64_t>> voxels;
  for (int64_t v = begin; v < end; ++v) {
    const int32_t y = grid.voxel_coord(v, 1) & 7, z = grid.voxel_coord(v, 2) & 7;
    voxels.push_back({{bricks::kTileWidth * (y + bricks::kTileWidth * z), material(v)}, v});
  }
  std::sort(voxels.begin(), voxels.end());
  for (size_t k = 0; k < voxels.size(); ++k) {
    const auto& [key, v] = voxels[k];
    if (k == 0 || voxels[k - 1].first != key) {
      g.rows.push_back({.offset = std::get<0>(key), .material = std::get<1>(key)});
      g.voxel.resize(g.voxel.size() + kLanes, -1);
    }
    const int lane = grid.voxel_coord(v, 0) & 7;
    g.rows.back().mask |= 1u << lane;
    g.slot[size_t(v)] = int32_t(kLanes * (g.rows.size() - 1)) + lane;
    g.voxel[size_t(g.slot[size_t(v)])] = int32_t(v);
  }
}

/// Moments of the rows that hold a voxel with its own shape means.
void add_border(const VoxelGrid& grid, BrickRows& g) {
  for (size_t r = 0; r < g.rows.size(); ++r) {
    bool border = false;
    for (int lane = 0; lane < kLanes; ++lane) {
      const int32_t v = g.voxel[kLanes * r + size_t(lane)];
      border |= v >= 0 && !is_full(grid, v);
    }
    if (!border) continue;
    g.rows[r].border = int32_t(g.border.size() / (7 * kLanes));
    g.border.resize(g.border.size() + 7 * kLanes);
    for (int lane = 0; lane < kLanes; ++lane) {
      const int32_t v = g.voxel[kLanes * r + size_t(lane)];
      if (v < 0 || is_full(grid, v)) continue;
      double M[7];
      hex8::fill_moments(grid.shape_mean.row(v), M);
      for (int p = 1; p < 7; ++p)
        g.border[size_t((g.rows[r].border * 7 + p) * kLanes + lane)] = M[p];
    }
  }
}

/// The nodes of one brick's voxels with their places in its tile.
void add_tile(const VoxelGrid& grid, int64_t begin, int64_t end, BrickRows& g,
              std::vector<int32_t>& bricks_of_node) {
  std::array<int32_t, bricks::kTile> node;
  node.fill(-1);
  for (int64_t v = begin; v < end; ++v) {
    const int x = grid.voxel_coord(v, 0) & 7, y = grid.voxel_coord(v, 1) & 7,
              z = grid.voxel_coord(v, 2) & 7;
    for (int c = 0; c < 8; ++c)
      node[size_t(x + (c & 1) + 9 * (y + (c >> 1 & 1) + 9 * (z + (c >> 2))))] = grid.corners(v, c);
  }
  for (int place = 0; place < bricks::kTile; ++place) {
    if (node[size_t(place)] < 0) continue;
    g.tile_node.push_back(node[size_t(place)]);
    g.tile_place.push_back(int16_t(place));
    ++bricks_of_node[size_t(node[size_t(place)])];
  }
  g.tile_begin.push_back(int32_t(g.tile_node.size()));
}

/// Partial sums of the nodes that several bricks hold, in the order of the bricks.
void number_parts(const std::vector<int32_t>& bricks_of_node, BrickRows& g) {
  std::vector<int32_t> next(bricks_of_node.size(), -1);
  int32_t parts = 0;
  for (size_t n = 0; n < bricks_of_node.size(); ++n) {
    if (bricks_of_node[n] < 2) continue;
    g.shared_node.push_back(int32_t(n));
    g.shared_begin.push_back(parts);
    next[n] = parts;
    parts += bricks_of_node[n];
  }
  g.shared_begin.push_back(parts);
  for (const int32_t node : g.tile_node)
    g.tile_part.push_back(next[size_t(node)] < 0 ? -1 : next[size_t(node)]++);
}

}  // namespace

BrickRows make_brick_rows(const VoxelGrid& grid, In<int32_t> material) {
  const int64_t voxels = grid.voxel_count();
  ELASTOGEN_CHECK(material.is(voxels, 1), "material must be (voxels, 1), got ", material);
  BrickRows g;
  g.slot.resize(size_t(voxels));
  g.row_begin.push_back(0);
  g.tile_begin.push_back(0);
  std::vector<int32_t> bricks_of_node(size_t(grid.node_count()));
  for (int64_t begin = 0; begin < voxels;) {
    int64_t end = begin;
    const Coord brick = brick_of(grid.voxel_coord, begin);
    while (end < voxels && brick_of(grid.voxel_coord, end) == brick) ++end;
    add_rows(grid, material, begin, end, g);
    g.row_begin.push_back(int32_t(g.rows.size()));
    add_tile(grid, begin, end, g, bricks_of_node);
    begin = end;
  }
  add_border(grid, g);
  number_parts(bricks_of_node, g);
  return g;
}

}  // namespace elastogen
