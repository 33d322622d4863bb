// SPDX-License-Identifier: Apache-2.0
#include "core/bricks/tiles.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

namespace elastogen {
namespace {

/// Whether a voxel lies in another brick than the voxel before it.
bool begins_brick(const VoxelGrid& grid, int64_t v) {
  for (int d = 0; d < 3 && v > 0; ++d)
    if (grid.voxel_coord(v, d) >> 3 != grid.voxel_coord(v - 1, d) >> 3) return true;
  return v == 0;
}

/// Node at each place of the tile of the voxels [begin, end), -1 where there is none.
std::array<int32_t, bricks::kTile> nodes_of_tile(const VoxelGrid& grid, int32_t begin,
                                                 int32_t end) {
  std::array<int32_t, bricks::kTile> node;
  node.fill(-1);
  for (int64_t v = begin; v < end; ++v) {
    const int x = grid.voxel_coord(v, 0) & 7, y = grid.voxel_coord(v, 1) & 7,
              z = grid.voxel_coord(v, 2) & 7;
    for (int c = 0; c < 8; ++c)
      node[size_t(x + (c & 1) + 9 * (y + (c >> 1 & 1) + 9 * (z + (c >> 2))))] = grid.corners(v, c);
  }
  return node;
}

/// Fills begins, nodes and places of the tiles.
void fill_tiles(const VoxelGrid& grid, const std::vector<int32_t>& first, BrickTiles& g) {
  // body(brick, nodes of its tile) for all bricks
  const auto in_tiles = [&](const auto& body) {
    run_tasks(int64_t(first.size()), [&](int64_t b) {
      const bool last = size_t(b + 1) == first.size();
      const int32_t end = last ? int32_t(grid.voxel_count()) : first[size_t(b + 1)];
      body(b, nodes_of_tile(grid, first[size_t(b)], end));
    });
  };
  // count of entries of each brick, and their sums
  g.tile_begin.assign(first.size() + 1, 0);
  in_tiles([&](int64_t b, const auto& nodes) {
    g.tile_begin[size_t(b + 1)] =
        int32_t(std::count_if(nodes.begin(), nodes.end(), [](int32_t n) { return n >= 0; }));
  });
  std::partial_sum(g.tile_begin.begin(), g.tile_begin.end(), g.tile_begin.begin());
  const auto entries = size_t(g.tile_begin.back());
  g.tile_node.resize(entries);
  g.tile_place.resize(entries);
  g.tile_part.resize(entries);
  // nodes and places, brick by brick
  in_tiles([&](int64_t b, const auto& nodes) {
    auto entry = size_t(g.tile_begin[size_t(b)]);
    for (size_t place = 0; place < nodes.size(); ++place) {
      if (nodes[place] < 0) continue;
      g.tile_node[entry] = nodes[place];
      g.tile_place[entry++] = int16_t(place);
    }
  });
}

/// Count of the bricks that hold a node and begin before a voxel; each is one side of the planes
/// between bricks on which the node lies.
int bricks_before(const VoxelGrid& grid, int64_t node, int32_t voxel) {
  int planes = 0;
  for (int d = 0; d < 3; ++d) planes |= ((grid.node_coord(node, d) & 7) == 0) << d;
  if (planes == 0) return 1;  // for any voxel
  unsigned sides = 0;
  for (int c = 0; c < 8; ++c)
    if (const int32_t v = grid.voxels(node, c); v >= 0 && v < voxel) sides |= 1u << (c & planes);
  return std::popcount(sides);
}

/// Numbers the partial sums of nodes that several bricks hold, in the order of the bricks.
void number_parts(const VoxelGrid& grid, const std::vector<int32_t>& first, BrickTiles& g) {
  const auto voxels = int32_t(grid.voxel_count());
  g.shared_node = filtered(grid.node_coord.rows(),
                           [&](int64_t n) { return bricks_before(grid, n, voxels) > 1; });
  const auto shared = int64_t(g.shared_node.size());
  g.shared_begin.resize(size_t(shared) + 1);
  for_each(shared, [&](int64_t s) {
    g.shared_begin[size_t(s + 1)] = bricks_before(grid, g.shared_node[size_t(s)], voxels);
  });
  std::partial_sum(g.shared_begin.begin(), g.shared_begin.end(), g.shared_begin.begin());
  Zeroed<int32_t> above(size_t(grid.node_coord.rows()));  // 1 + the first part of a shared node
  for_each(shared, [&](int64_t s) {
    above[size_t(g.shared_node[size_t(s)])] = 1 + g.shared_begin[size_t(s)];
  });
  run_tasks(g.brick_count(), [&](int64_t b) {
    for (int32_t k = g.tile_begin[size_t(b)]; k < g.tile_begin[size_t(b + 1)]; ++k) {
      const int32_t node = g.tile_node[size_t(k)], part = above[size_t(node)];
      g.tile_part[size_t(k)] =
          part == 0 ? -1 : part - 1 + bricks_before(grid, node, first[size_t(b)]);
    }
  });
}

}  // namespace

std::vector<int32_t> first_voxels(const VoxelGrid& grid) {
  return filtered(grid.voxel_count(), [&](int64_t v) { return begins_brick(grid, v); });
}

BrickTiles make_brick_tiles(const VoxelGrid& grid, const std::vector<int32_t>& first) {
  BrickTiles g;
  fill_tiles(grid, first, g);
  number_parts(grid, first, g);
  return g;
}

}  // namespace elastogen
