// SPDX-License-Identifier: Apache-2.0
#include "network/potential/brick_rows.hpp"

#include "core/error.hpp"
#include "core/hex8.hpp"

#include <algorithm>
#include <array>

namespace elastogen {
namespace {

/// The rows of the voxels [begin, end) of a brick, before their numbers in the grid are known.
struct Brick {
  int32_t begin, end;
  std::vector<VoxelRow> rows;   ///< border is a mark here: 0 with border voxels, else -1
  std::vector<int32_t> row_of;  ///< row of each voxel
  int32_t first_row = 0, first_border = 0, borders = 0;
};

/// Adds the rows of a line of voxels, one for each material, in the order of the materials.
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

std::vector<Brick> make_bricks(const VoxelGrid& grid, const std::vector<int32_t>& first,
                               In<int32_t> material) {
  std::vector<Brick> bricks(first.size());
  run_tasks(int64_t(bricks.size()), [&](int64_t b) {
    Brick& brick = bricks[size_t(b)];
    brick.begin = first[size_t(b)];
    brick.end = size_t(b + 1) < first.size() ? first[size_t(b + 1)] : int32_t(grid.voxel_count());
    add_rows(grid, material, brick);
  });
  return bricks;
}

/// Allocates the tables, and finds the first row and the first border index of each brick.
void number_bricks(std::vector<Brick>& bricks, BrickRows& g) {
  int32_t rows = 0, borders = 0;
  g.row_begin.push_back(0);
  for (Brick& brick : bricks) {
    brick.first_row = rows, brick.first_border = borders;
    g.row_begin.push_back(rows += int32_t(brick.rows.size()));
    borders += brick.borders;
  }
  g.rows.resize(size_t(rows));
  g.voxel.resize(size_t(rows) * kLanes);
  g.border.resize(size_t(borders) * 7 * kLanes);
}

/// Writes rows, slots and the moments of border voxels.
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

}  // namespace

BrickRows make_brick_rows(const VoxelGrid& grid, In<int32_t> material) {
  const int64_t voxels = grid.voxel_count();
  ELASTOGEN_CHECK(material.is(voxels, 1), "material must be (voxels, 1), got ", material);
  const std::vector<int32_t> first = first_voxels(grid);
  std::vector<Brick> bricks = make_bricks(grid, first, material);
  BrickRows g;
  static_cast<BrickTiles&>(g) = make_brick_tiles(grid, first);
  g.slot.resize(size_t(voxels));
  number_bricks(bricks, g);
  run_tasks(int64_t(bricks.size()), [&](int64_t b) { write_rows(grid, bricks[size_t(b)], g); });
  return g;
}

BrickRows make_brick_rows(const Scene& scene) {
  return make_brick_rows(scene.grid, scene.material);
}

}  // namespace elastogen
