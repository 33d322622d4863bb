// SPDX-License-Identifier: Apache-2.0
#include "network/mesh_number/coarse_grid.hpp"

#include "core/bricks/index.hpp"
#include "core/parallel.hpp"
#include "voxelize/bricks.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace elastogen {
namespace {

/// Lattice of the coarse grid: a fine point of a piece lies at its coordinate plus the offset, in
/// units of h, and pieces are shifted along x by an even number.
struct CoarseLattice {
  Coord offset = {};
  std::vector<int32_t> shift;  // of each piece

  Coord at(const int32_t* fine, int32_t piece) const {
    return {fine[0] + offset[0] + shift[size_t(piece)], fine[1] + offset[1], fine[2] + offset[2]};
  }
};

Coord halved(const Coord& at) {
  return {at[0] >> 1, at[1] >> 1, at[2] >> 1};  // rounded down
}

int32_t piece_of(const VoxelGrid& grid, int64_t voxel) {
  return grid.piece(grid.corners(voxel, 0));
}

/// Shifts that lay the pieces side by side with two coarse voxels between them; none for one piece,
/// or where the lattice is too short.
std::vector<int32_t> shifts_of(const VoxelGrid& grid) {
  std::vector<int32_t> shift(size_t(grid.pieces), 0);
  if (grid.pieces < 2) return shift;
  std::vector<int32_t> low(shift.size(), kLatticeLimit), high(shift.size(), -kLatticeLimit);
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    const auto p = size_t(grid.piece(n));
    low[p] = std::min(low[p], grid.node_coord(n, 0));
    high[p] = std::max(high[p], grid.node_coord(n, 0));
  }
  int64_t next = -kLatticeLimit;
  for (size_t p = 0; p < shift.size(); ++p) {
    const int64_t even_low = low[p] - (low[p] & 1);
    shift[p] = int32_t(next - even_low);
    next += (high[p] - even_low) / 2 * 2 + 8;
    if (next >= kLatticeLimit) return std::vector<int32_t>(shift.size(), 0);
  }
  return shift;
}

/// Nodes on the rim of what is held, of each parity of their coordinates.
std::array<int64_t, 8> rim_counts(const VoxelGrid& grid, In<uint8_t> held) {
  std::array<int64_t, 8> count = {};
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    if (!held(n)) continue;
    bool rim = false;
    for (int c = 0; c < 8 && !rim; ++c)
      for (int k = 0; k < 8 && !rim; ++k) {
        const int32_t v = grid.voxels(n, c);
        rim = v >= 0 && !held(grid.corners(v, k));
      }
    const int32_t* at = grid.node_coord.row(n);
    count[size_t((at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2)] += rim;
  }
  return count;
}

BrickIndex coarse_voxels(const VoxelGrid& fine, const CoarseLattice& lattice) {
  Array<int32_t> coords(fine.voxel_count(), 3);
  for_each(fine.voxel_count(), [&](int64_t v) {
    const Coord at = halved(lattice.at(fine.voxel_coord.row(v), piece_of(fine, v)));
    std::copy(at.begin(), at.end(), coords.row(v));
  });
  BrickIndex index{In<int32_t>(coords)};
  return index;
}

CoarseLattice best_lattice(const VoxelGrid& fine, In<uint8_t> held) {
  const std::array<int64_t, 8> rim = rim_counts(fine, held);
  CoarseLattice best;
  std::tuple<int64_t, int64_t> score = {-1, 0};
  for (int parity = 0; parity < 8; ++parity) {
    if (rim[size_t(parity)] < std::get<0>(score)) continue;
    CoarseLattice lattice{{parity & 1, parity >> 1 & 1, parity >> 2}, shifts_of(fine)};
    const int64_t voxels = coarse_voxels(fine, lattice).point_count();
    const std::tuple<int64_t, int64_t> here = {rim[size_t(parity)], -voxels};
    if (here <= score) continue;
    score = here;
    best = std::move(lattice);
  }
  return best;
}

/// Links between voxels and nodes of the two grids.
void link(const VoxelGrid& fine, const CoarseLattice& lattice, const BrickIndex& voxels,
          CoarseGrid& coarse) {
  coarse.children = Array<int32_t>(voxels.point_count(), 8);
  coarse.children.fill(-1);
  for_each(fine.voxel_count(), [&](int64_t v) {
    const Coord at = lattice.at(fine.voxel_coord.row(v), piece_of(fine, v));
    const int c = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
    coarse.children(voxels.find(halved(at)), c) = int32_t(v);
  });
  const BrickIndex nodes = voxels.corners();
  coarse.parents = Array<int32_t>(fine.node_count(), 8);
  coarse.around = Array<int32_t>(nodes.point_count(), 27);
  coarse.around.fill(-1);
  for_each(fine.node_count(), [&](int64_t n) {
    const Coord at = lattice.at(fine.node_coord.row(n), fine.piece(n));
    for (int c = 0; c < 8; ++c) {
      const Coord place = halved({at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2)});
      const auto parent = int32_t(nodes.find(place));
      coarse.parents(n, c) = parent;
      // each row and place belongs to one fine node
      const int x = at[0] - 2 * place[0], y = at[1] - 2 * place[1], z = at[2] - 2 * place[2];
      coarse.around(parent, kSamePlace + x + 3 * y + 9 * z) = int32_t(n);
    }
  });
}

/// The member of a voxel of whose children one has it: the mean of these over the layers that they make
/// across its thin axes.
void take_member(const VoxelGrid& fine, CoarseGrid& coarse, int64_t v) {
  double sum = 0;
  int count = 0, sides[3] = {};
  bool is_cut = false;
  for (int child = 0; child < 8; ++child) {
    const int32_t of = coarse.children(v, child);
    if (of < 0) continue;
    ++count;
    is_cut |= fine.member(of) > 0;
    sum += fine.member(of) > 0 ? fine.member(of) : fine.fill(of);
    for (int d = 0; d < 3; ++d) sides[d] |= 1 << (child >> d & 1);
  }
  if (!is_cut) return;
  double& member = coarse.grid.member(v) = sum / count;
  const int thin = thin_axes(coarse.grid, v);
  for (int d = 0; d < 3; ++d)
    if (thin >> d & 1 && sides[d] != 3) member /= 2;
}

/// Fill, means of shape functions and thickness of layers, from the children.
void fill_voxels(const VoxelGrid& fine, CoarseGrid& coarse) {
  VoxelGrid& grid = coarse.grid;
  if (!fine.sheet.empty()) grid.sheet = Array<double>(grid.voxel_count());
  if (!fine.member.empty()) grid.member = Array<double>(grid.voxel_count());
  for_each(grid.voxel_count(), [&](int64_t v) {
    double fill = 0, mean[8] = {};
    for (int child = 0; child < 8; ++child) {
      const int32_t of = coarse.children(v, child);
      if (of < 0) continue;
      fill += fine.fill(of);
      if (!fine.sheet.empty()) grid.sheet(v) = std::max(grid.sheet(v), fine.sheet(of) / 2);
      for (int corner = 0; corner < 8; ++corner)
        for (int c = 0; c < 8; ++c) {
          // the coarse shape function c at the child's corner: each factor is 0, 1/2 or 1
          double shape = 1;
          for (int d = 0; d < 3; ++d) {
            const double t = 0.5 * ((child >> d & 1) + (corner >> d & 1));
            shape *= c >> d & 1 ? t : 1 - t;
          }
          mean[c] += fine.fill(of) * fine.shape_mean(of, corner) * shape;
        }
    }
    grid.fill(v) = fill / 8;
    if (!fine.member.empty()) take_member(fine, coarse, v);
    for (int c = 0; c < 8; ++c) grid.shape_mean(v, c) = mean[c] / fill;
  });
  grid.volume = fine.volume;
}

/// Rest positions, wherever the pieces stand on the lattice.
void place_nodes(const VoxelGrid& fine, const CoarseLattice& lattice, CoarseGrid& coarse) {
  VoxelGrid& grid = coarse.grid;
  for_each(grid.node_count(), [&](int64_t n) {
    int k = 0;
    while (coarse.around(n, k) < 0) ++k;
    const int32_t near = coarse.around(n, k);
    const int offset[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
    for (int d = 0; d < 3; ++d) grid.rest(n, d) = fine.rest(near, d) - fine.h * offset[d];
    // the node at the same place has the same bits
    if (const int32_t same = coarse.around(n, kSamePlace); same >= 0)
      std::copy_n(fine.rest.row(same), 3, grid.rest.row(n));
  });
  for (int d = 0; d < 3; ++d)
    grid.origin[size_t(d)] = fine.origin[size_t(d)] - fine.h * lattice.offset[size_t(d)];
}

double share_of(int place) {
  const int offset[3] = {place % 3 - 1, place / 3 % 3 - 1, place / 9 - 1};
  double share = 1;
  for (const int o : offset) share *= o == 0 ? 1 : 0.5;
  return share;
}

}  // namespace

CoarseGrid coarse_grid(const VoxelGrid& fine, In<uint8_t> held) {
  const CoarseLattice lattice = best_lattice(fine, held);
  const BrickIndex voxels = coarse_voxels(fine, lattice);
  CoarseGrid coarse;
  coarse.grid = make_grid(voxels.points(), 2 * fine.h, fine.origin);
  link(fine, lattice, voxels, coarse);
  fill_voxels(fine, coarse);
  place_nodes(fine, lattice, coarse);
  return coarse;
}

void prolong(const CoarseGrid& coarse, const double* values, double* fine) {
  for_each(coarse.parents.rows(), [&](int64_t n) {
    const int32_t* parents = coarse.parents.row(n);
    for (int i = 0; i < 3; ++i) {
      double sum = 0;
      for (int c = 0; c < 8; ++c) sum += values[3 * int64_t(parents[c]) + i];
      fine[3 * n + i] = sum / 8;
    }
  });
}

void restrict_sum(const CoarseGrid& coarse, int columns, const double* fine, double* sums) {
  for_each(coarse.around.rows(), [&](int64_t n) {
    for (int i = 0; i < columns; ++i) sums[columns * n + i] = 0;
    for (int k = 0; k < 27; ++k) {
      const int32_t of = coarse.around(n, k);
      if (of < 0) continue;
      const double share = share_of(k);
      for (int i = 0; i < columns; ++i)
        sums[columns * n + i] += share * fine[columns * int64_t(of) + i];
    }
  });
}

}  // namespace elastogen
