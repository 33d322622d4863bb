// SPDX-License-Identifier: Apache-2.0
#include "network/brick_rows.hpp"

#include "core/error.hpp"
#include "core/hex8.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

namespace elastogen {
namespace {

/// Whether a voxel lies in another brick than the one before.
bool begins_brick(const VoxelGrid& grid, int64_t v) {
  for (int d = 0; d < 3 && v > 0; ++d)
    if (grid.voxel_coord(v, d) >> 3 != grid.voxel_coord(v - 1, d) >> 3) return true;
  return v == 0;
}

/// What is made of the voxels [begin, end) of a brick before the numbers of those before are known.
struct Brick {
  int32_t begin, end;
  std::vector<VoxelRow> rows;   ///< border as yet a mark: 0
  std::vector<int32_t> row_of;  ///< of each voxel
  std::vector<int32_t> tile_node;
  std::vector<int16_t> tile_place;
  int32_t first_row = 0, first_entry = 0, first_border = 0, borders = 0;
};

/// Rows of a line of voxels, a material each, in the order of the materials.
void add_line(const VoxelGrid& grid, In<int32_t> material, int64_t begin, int64_t end,
              Brick& brick) {
  const int32_t y = grid.voxel_coord(begin, 1) & 7, z = grid.voxel_coord(begin, 2) & 7;
  std::array<int32_t, kLanes> order;
  const auto last = std::copy(material.data + begin, material.data + end, order.begin());
  std::sort(order.begin(), last);
  for (auto m = order.begin(); m != last; m = std::upper_bound(m, last, *m)) {
    VoxelRow row{.offset = bricks::kTileWidth * (y + bricks::kTileWidth * z), .material = *m};
    for (int64_t v = begin; v < end; ++v) {
      if (material(v) != *m) continue;
      row.mask |= 1u << (grid.voxel_coord(v, 0) & 7);
      if (!is_full(grid, v)) row.border = 0;
      brick.row_of[size_t(v - brick.begin)] = int32_t(brick.rows.size());
    }
    brick.borders += row.border == 0;
    brick.rows.push_back(row);
  }
}

void add_rows(const VoxelGrid& grid, In<int32_t> material, Brick& brick) {
  brick.row_of.resize(size_t(brick.end - brick.begin));
  for (int64_t begin = brick.begin, end = begin; begin < brick.end; begin = end) {
    while (end < brick.end && grid.voxel_coord(end, 1) == grid.voxel_coord(begin, 1) &&
           grid.voxel_coord(end, 2) == grid.voxel_coord(begin, 2))
      ++end;
    add_line(grid, material, begin, end, brick);
  }
}

/// The nodes of a brick's voxels with their places in its tile.
void add_tile(const VoxelGrid& grid, Brick& brick) {
  std::array<int32_t, bricks::kTile> node;
  node.fill(-1);
  for (int64_t v = brick.begin; v < brick.end; ++v) {
    const int x = grid.voxel_coord(v, 0) & 7, y = grid.voxel_coord(v, 1) & 7,
              z = grid.voxel_coord(v, 2) & 7;
    for (int c = 0; c < 8; ++c)
      node[size_t(x + (c & 1) + 9 * (y + (c >> 1 & 1) + 9 * (z + (c >> 2))))] = grid.corners(v, c);
  }
  for (int place = 0; place < bricks::kTile; ++place) {
    if (node[size_t(place)] < 0) continue;
    brick.tile_node.push_back(node[size_t(place)]);
    brick.tile_place.push_back(int16_t(place));
  }
}

std::vector<Brick> make_bricks(const VoxelGrid& grid, In<int32_t> material) {
  const int64_t voxels = grid.voxel_count();
  const std::vector<int32_t> begin =
      filtered(voxels, [&](int64_t v) { return begins_brick(grid, v); });
  std::vector<Brick> bricks(begin.size());
  run_tasks(int64_t(bricks.size()), [&](int64_t b) {
    Brick& brick = bricks[size_t(b)];
    brick.begin = begin[size_t(b)];
    brick.end = size_t(b + 1) < begin.size() ? begin[size_t(b + 1)] : int32_t(voxels);
    add_rows(grid, material, brick);
    add_tile(grid, brick);
  });
  return bricks;
}

/// Makes room for all, and gives each brick its place.
void number_bricks(std::vector<Brick>& bricks, BrickRows& g) {
  int32_t rows = 0, entries = 0, borders = 0;
  g.row_begin.push_back(0);
  g.tile_begin.push_back(0);
  for (Brick& brick : bricks) {
    brick.first_row = rows, brick.first_entry = entries, brick.first_border = borders;
    g.row_begin.push_back(rows += int32_t(brick.rows.size()));
    g.tile_begin.push_back(entries += int32_t(brick.tile_node.size()));
    borders += brick.borders;
  }
  g.rows.resize(size_t(rows));
  g.voxel.resize(size_t(rows) * kLanes);
  g.border.resize(size_t(borders) * 7 * kLanes);
  g.tile_node.resize(size_t(entries));
  g.tile_place.resize(size_t(entries));
  g.tile_part.resize(size_t(entries));
}

/// Rows, slots and the moments of border voxels.
void write_rows(const VoxelGrid& grid, const Brick& brick, BrickRows& g) {
  int32_t border = brick.first_border;
  for (size_t r = 0; r < brick.rows.size(); ++r) {
    VoxelRow& row = g.rows[size_t(brick.first_row) + r] = brick.rows[r];
    if (row.border == 0) row.border = border++;
    std::fill_n(g.voxel.begin() + kLanes * (brick.first_row + int64_t(r)), kLanes, -1);
  }
  for (int32_t v = brick.begin; v < brick.end; ++v) {
    const int32_t row = brick.first_row + brick.row_of[size_t(v - brick.begin)];
    const int lane = grid.voxel_coord(v, 0) & 7;
    g.slot[size_t(v)] = kLanes * row + lane;
    g.voxel[size_t(kLanes * row + lane)] = v;
    if (g.rows[size_t(row)].border < 0 || is_full(grid, v)) continue;
    double M[7];
    hex8::fill_moments(grid.shape_mean.row(v), M);
    for (int p = 1; p < 7; ++p)
      g.border[size_t((g.rows[size_t(row)].border * 7 + p) * kLanes + lane)] = M[p];
  }
}

/// Bricks that hold a node and begin before a voxel: sides of the planes between bricks on which
/// the node lies.
int bricks_before(const VoxelGrid& grid, int64_t node, int32_t voxel) {
  int planes = 0;
  for (int d = 0; d < 3; ++d) planes |= ((grid.node_coord(node, d) & 7) == 0) << d;
  if (planes == 0) return 1;  // whatever the voxel
  unsigned sides = 0;
  for (int c = 0; c < 8; ++c)
    if (const int32_t v = grid.voxels(node, c); v >= 0 && v < voxel) sides |= 1u << (c & planes);
  return std::popcount(sides);
}

/// Partial sums of the nodes that several bricks hold, in the order of the bricks.
void number_parts(const VoxelGrid& grid, const std::vector<Brick>& bricks, BrickRows& g) {
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
  run_tasks(int64_t(bricks.size()), [&](int64_t b) {
    const Brick& brick = bricks[size_t(b)];
    for (size_t k = 0; k < brick.tile_node.size(); ++k) {
      const size_t entry = size_t(brick.first_entry) + k;
      const int32_t node = brick.tile_node[k], first = above[size_t(node)];
      g.tile_node[entry] = node;
      g.tile_place[entry] = brick.tile_place[k];
      g.tile_part[entry] = first == 0 ? -1 : first - 1 + bricks_before(grid, node, brick.begin);
    }
  });
}

}  // namespace

BrickRows make_brick_rows(const VoxelGrid& grid, In<int32_t> material) {
  const int64_t voxels = grid.voxel_count();
  ELASTOGEN_CHECK(material.is(voxels, 1), "material must be (voxels, 1), got ", material);
  std::vector<Brick> bricks = make_bricks(grid, material);
  BrickRows g;
  g.slot.resize(size_t(voxels));
  number_bricks(bricks, g);
  run_tasks(int64_t(bricks.size()), [&](int64_t b) { write_rows(grid, bricks[size_t(b)], g); });
  number_parts(grid, bricks, g);
  return g;
}

BrickRows make_brick_rows(const Scene& scene) {
  return make_brick_rows(scene.grid, scene.material);
}

}  // namespace elastogen
