// SPDX-License-Identifier: Apache-2.0
#include "voxelize/bricks.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "voxelize/brick_index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

void check(In<int32_t> coords, double h, const Vec3& origin) {
  ELASTOGEN_CHECK(coords.cols == 3, "coords must be (voxels, 3), got ", coords);
  ELASTOGEN_CHECK(h > 0 && std::isfinite(h), "h must be positive, got ", h);
  for (const double x : origin) ELASTOGEN_CHECK(std::isfinite(x), "origin must be finite");
  for (int64_t i = 0; i < coords.size(); ++i)
    ELASTOGEN_CHECK(coords.data[i] >= -kLatticeLimit && coords.data[i] < kLatticeLimit - 1,
                    "coordinates must lie within +-2^20, voxel ", i / 3, " has ", coords.data[i]);
}

Coord point(In<int32_t> coords, int64_t row) {
  return {coords(row, 0), coords(row, 1), coords(row, 2)};
}

Coord corner_of(const Coord& voxel, int c) {
  return {voxel[0] + (c & 1), voxel[1] + (c >> 1 & 1), voxel[2] + (c >> 2)};
}

/// The nodes of sorted voxels: first the bricks that can hold one, then a bit for each.
BrickIndex node_index(In<int32_t> voxels) {
  std::vector<uint64_t> keys;
  uint64_t last = ~uint64_t{0};
  for (int64_t v = 0; v < voxels.rows; ++v) {
    const uint64_t brick = brick_key(point(voxels, v)) >> 9;
    if (brick == last) continue;
    last = brick;
    for (int c = 0; c < 8; ++c) {
      Coord neighbour = point(voxels, v);
      for (int d = 0; d < 3; ++d) neighbour[d] = (neighbour[d] & ~7) + 8 * (c >> d & 1);
      if (*std::max_element(neighbour.begin(), neighbour.end()) < kLatticeLimit)
        keys.push_back(brick_key(neighbour) >> 9);
    }
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return BrickIndex(std::move(keys));
}

/// Calls visit(voxel, corner, brick of the node, its place there) for the voxels of one range.
template <class Visit>
void for_each_corner(In<int32_t> voxels, const BrickIndex& nodes, int64_t first, int64_t last,
                     const Visit& visit) {
  uint64_t brick = ~uint64_t{0};
  int64_t around[8] = {};
  for (int64_t v = first; v < last; ++v) {
    const Coord voxel = point(voxels, v);
    if (const uint64_t key = brick_key(voxel) >> 9; key != brick) {
      brick = key;
      std::fill(around, around + 8, -2);
    }
    for (int c = 0; c < 8; ++c) {
      const Coord node = corner_of(voxel, c);
      int side = 0, place = 0;
      for (int d = 0; d < 3; ++d) {
        side |= (node[d] >> 3 != voxel[d] >> 3) << d;
        place |= (node[d] & 7) << (3 * d);
      }
      if (around[side] == -2) around[side] = nodes.find_brick(brick_key(node) >> 9);
      visit(v, c, around[side], place);
    }
  }
}

void fill_tables(const BrickIndex& nodes, VoxelGrid& grid) {
  const int64_t voxels = grid.voxel_coord.rows();
  for_blocks(voxels, [&](int64_t begin, int64_t end) {
    for_each_corner(grid.voxel_coord, nodes, begin, end,
                    [&](int64_t v, int c, int64_t brick, int place) {
                      const auto node = static_cast<int32_t>(nodes.find(brick, place));
                      grid.corners(v, c) = node;
                      grid.voxels(node, c) = static_cast<int32_t>(v);
                    });
  });
}

/// Numbers connected pieces in the order of their first node.
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
  // a root is the smallest node of its piece
  for (int32_t n = 0; n < grid.node_count(); ++n) {
    const int32_t r = root(n);
    grid.piece(n) = r == n ? grid.pieces++ : grid.piece(r);
  }
}

}  // namespace

VoxelGrid make_grid(In<int32_t> coords, double h, const Vec3& origin) {
  check(coords, h, origin);
  VoxelGrid grid;
  grid.h = h;
  grid.origin = origin;

  // voxels in order
  grid.voxel_coord = BrickIndex(coords).points();
  const int64_t voxels = coords.rows;
  ELASTOGEN_CHECK(grid.voxel_coord.rows() == voxels, voxels - grid.voxel_coord.rows(),
                  " coordinates stand twice");

  // nodes in order
  BrickIndex index = node_index(grid.voxel_coord);
  for_each_corner(grid.voxel_coord, index, 0, voxels,
                  [&](int64_t, int, int64_t brick, int place) { index.insert(brick, place); });
  const int64_t nodes = index.number();
  ELASTOGEN_CHECK(nodes < int64_t{1} << 31, "too many nodes for 32-bit tables: ", nodes);
  grid.node_coord = index.points();

  // tables
  grid.corners = Array<int32_t>(voxels, 8);
  grid.voxels = Array<int32_t>(nodes, 8);
  grid.voxels.fill(-1);
  fill_tables(index, grid);
  grid.rest = Array<double>(nodes, 3);
  for_each(nodes, [&](int64_t n) {
    for (int d = 0; d < 3; ++d) grid.rest(n, d) = origin[d] + h * grid.node_coord(n, d);
  });
  grid.piece = Array<int32_t>(nodes, 1);
  fill_pieces(grid);

  // full
  grid.fill = Array<double>(voxels, 1);
  grid.fill.fill(1);
  grid.shape_mean = Array<double>(voxels, 8);
  grid.shape_mean.fill(0.125);
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
