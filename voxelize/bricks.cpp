// SPDX-License-Identifier: Apache-2.0
#include "voxelize/bricks.hpp"

#include "core/bricks/index.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

void check(In<int32_t> coords, double h, const Vec3& origin) {
  ELASTOGEN_CHECK(coords.cols == 3, "coords must be (voxels, 3), got ", coords);
  ELASTOGEN_CHECK(h > 0 && std::isfinite(h), "h must be positive, got ", h);
  for (const double x : origin) ELASTOGEN_CHECK(std::isfinite(x), "origin must be finite");
  const std::vector<int32_t> outside = filtered(coords.rows, [&](int64_t v) {
    const auto [low, high] = std::minmax_element(coords.row(v), coords.row(v) + 3);
    return *low < -kLatticeLimit || *high >= kLatticeLimit - 1;
  });
  ELASTOGEN_CHECK(outside.empty(), "coordinates must lie within +-2^20, voxel ", outside.front(),
                  " does not");
}

Coord point(In<int32_t> coords, int64_t row) {
  return {coords(row, 0), coords(row, 1), coords(row, 2)};
}

Coord corner_of(const Coord& voxel, int c) {
  return {voxel[0] + (c & 1), voxel[1] + (c >> 1 & 1), voxel[2] + (c >> 2)};
}

/// Writes the corner nodes of the voxels [first, last).
void fill_corners(const BrickIndex& nodes, int64_t first, int64_t last, VoxelGrid& grid) {
  // bricks of nodes around the voxel's brick are looked up once
  uint64_t brick = ~uint64_t{0};
  int64_t around[8] = {};
  for (int64_t v = first; v < last; ++v) {
    const Coord voxel = point(grid.voxel_coord, v);
    if (const uint64_t key = brick_key(voxel) >> 9; key != brick) {
      brick = key;
      std::fill(around, around + 8, -2);
    }
    int32_t* corner = grid.corners.row(v);
    for (int c = 0; c < 8; ++c) {
      if (c % 2 == 1 && (voxel[0] & 7) < 7) {  // the neighbour along x in this brick
        corner[c] = corner[c - 1] + 1;
        continue;
      }
      // brick and place of the node
      const Coord node = corner_of(voxel, c);
      int side = 0, place = 0;
      for (int d = 0; d < 3; ++d) {
        side |= (node[d] >> 3 != voxel[d] >> 3) << d;
        place |= (node[d] & 7) << (3 * d);
      }
      if (around[side] == -2) around[side] = nodes.find_brick(brick_key(node) >> 9);
      corner[c] = static_cast<int32_t>(nodes.find(around[side], place));
    }
  }
}

/// Numbers the connected pieces in the order of their first nodes.
void fill_pieces(VoxelGrid& grid) {
  std::vector<int32_t> parent(grid.node_count());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int32_t n) {
    while (parent[n] != n) n = parent[n] = parent[parent[n]];
    return n;
  };
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    int32_t first = root(grid.corners(v, 0));
    for (int c = 1; c < 8; ++c) {
      const int32_t other = root(grid.corners(v, c));
      parent[std::max(first, other)] = std::min(first, other);
      first = std::min(first, other);
    }
  }
  // the root of a piece is its smallest node
  for (int32_t n = 0; n < grid.node_count(); ++n) {
    const int32_t r = root(n);
    grid.piece(n) = r == n ? grid.pieces++ : grid.piece(r);
  }
}

}  // namespace

VoxelGrid make_tables(const BrickIndex& voxels, const BrickIndex& nodes) {
  VoxelGrid grid;
  grid.voxel_coord = voxels.points();
  grid.node_coord = nodes.points();
  grid.corners = Array<int32_t>(voxels.point_count(), 8);
  grid.voxels = Array<int32_t>(nodes.point_count(), 8);
  for_each(grid.voxels.size(), [&](int64_t k) { grid.voxels.data()[k] = -1; });
  for_blocks(voxels.point_count(), [&](int64_t begin, int64_t end) {
    fill_corners(nodes, begin, end, grid);
    for (int64_t v = begin; v < end; ++v)
      for (int c = 0; c < 8; ++c) grid.voxels(grid.corners(v, c), c) = static_cast<int32_t>(v);
  });
  return grid;
}

VoxelGrid make_grid(In<int32_t> coords, double h, const Vec3& origin) {
  check(coords, h, origin);
  const BrickIndex index(coords);
  const int64_t voxels = index.point_count();
  ELASTOGEN_CHECK(voxels == coords.rows, coords.rows - voxels, " coordinates stand twice");
  const BrickIndex node_index = index.corners();
  const int64_t nodes = node_index.point_count();
  ELASTOGEN_CHECK(nodes < int64_t{1} << 31, "too many nodes for 32-bit tables: ", nodes);

  VoxelGrid grid = make_tables(index, node_index);
  grid.h = h;
  grid.origin = origin;
  grid.rest = Array<double>(nodes, 3);
  for_each(nodes, [&](int64_t n) {
    for (int d = 0; d < 3; ++d) grid.rest(n, d) = origin[d] + h * grid.node_coord(n, d);
  });
  grid.piece = Array<int32_t>(nodes, 1);
  fill_pieces(grid);

  // all voxels are full
  grid.fill = Array<double>(voxels, 1);
  grid.shape_mean = Array<double>(voxels, 8);
  for_each(voxels, [&](int64_t v) {
    grid.fill(v) = 1;
    std::fill_n(grid.shape_mean.row(v), 8, 0.125);
  });
  grid.volume = static_cast<double>(voxels) * h * h * h;
  return grid;
}

VoxelGrid make_box(int nx, int ny, int nz, double h, const Vec3& origin) {
  ELASTOGEN_CHECK(nx > 0 && ny > 0 && nz > 0, "a box needs a voxel along each axis, got ", nx,
                  " x ", ny, " x ", nz);
  Array<int32_t> coords(int64_t{nx} * ny * nz, 3);
  int64_t v = 0;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x, ++v) {
        coords(v, 0) = x;
        coords(v, 1) = y;
        coords(v, 2) = z;
      }
  return make_grid(coords, h, origin);
}

}  // namespace elastogen
