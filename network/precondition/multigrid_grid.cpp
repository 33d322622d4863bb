// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/multigrid_grid.hpp"

#include "core/reduce.hpp"
#include "voxelize/bricks.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// Looks up lattice points, most of which lie in the brick of the one before.
class Lookup {
 public:
  explicit Lookup(const BrickIndex& index) : index_(index) {}
  /// Number of the point, -1 if it is not there.
  int32_t operator()(int32_t x, int32_t y, int32_t z) {
    if (x >> 3 != brick_[0] || y >> 3 != brick_[1] || z >> 3 != brick_[2]) {
      brick_ = {x >> 3, y >> 3, z >> 3};
      place_ = index_.find_brick(brick_key({x, y, z}) >> 9);
    }
    return place_ < 0 ? -1 : int32_t(index_.find(place_, (x & 7) | (y & 7) << 3 | (z & 7) << 6));
  }

 private:
  const BrickIndex& index_;
  Coord brick_ = {INT32_MAX, INT32_MAX, INT32_MAX};  // no brick of a point
  int64_t place_ = -1;
};

/// Means over the eight children, missing ones counted as 0; one variance weight for all patterns.
void average_moduli(const LevelGrid& fine, const Array<int32_t>& voxel_coord, LevelGrid& coarse) {
  const int64_t voxels = voxel_coord.rows();
  coarse.moduli.resize(6 * size_t(voxels));
  for_blocks(voxels, [&](int64_t begin, int64_t end) {
    Lookup find(fine.voxel_index);
    for (int64_t v = begin; v < end; ++v) {
      const int32_t* at = voxel_coord.row(v);
      double* sum = coarse.moduli.data() + 6 * v;
      for (int c = 0; c < 8; ++c) {
        const int32_t child =
            find(2 * at[0] + (c & 1), 2 * at[1] + (c >> 1 & 1), 2 * at[2] + (c >> 2));
        if (child < 0) continue;
        const double* k = fine.moduli.data() + 6 * child;
        sum[0] += k[0] / 8;
        sum[1] += k[1] / 8;
        const double variance = (k[2] + k[3] + k[4] + k[5]) / 4;
        for (int j = 2; j < 6; ++j) sum[j] += variance / 8;
      }
    }
  });
}

/// Axes along which a node has odd coordinates, as bits.
int odd_axes(const int32_t at[3]) {
  return (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
}

/// Parents of the fine nodes: an even coordinate has one parent, an odd one the two beside it.
void find_parents(const LevelGrid& coarse, LevelGrid& fine) {
  fine.parents.resize(8 * size_t(fine.nodes));
  for_blocks(fine.nodes, [&](int64_t begin, int64_t end) {
    Lookup find(coarse.node_index);
    for (int64_t n = begin; n < end; ++n) {
      const int32_t* at = fine.node_coord.row(n);
      int32_t* parents = fine.parents.data() + 8 * n;
      const int odd = odd_axes(at);
      for (int c = 0; c < 8; ++c) {
        if ((c & odd) != c) {
          parents[c] = parents[c & odd];
          continue;
        }
        const int32_t parent =
            find((at[0] >> 1) + (c & 1), (at[1] >> 1) + (c >> 1 & 1), (at[2] >> 1) + (c >> 2));
        parents[c] = coarse.pinned[size_t(parent)] ? -1 : parent;
      }
    }
  });
}

/// Finds children and masses of the coarse nodes; nodes on a pinned node are pinned.
void find_children(const LevelGrid& fine, LevelGrid& coarse) {
  coarse.children.resize(27 * size_t(coarse.nodes));
  for_blocks(coarse.nodes, [&](int64_t begin, int64_t end) {
    Lookup find(fine.node_index);
    for (int64_t n = begin; n < end; ++n) {
      const int32_t* at = coarse.node_coord.row(n);
      double inertia = 0;
      for (int k = 0; k < 27; ++k) {
        const int o[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const int32_t child = find(2 * at[0] + o[0], 2 * at[1] + o[1], 2 * at[2] + o[2]);
        coarse.children[size_t(27 * n + k)] = child;
        if (child < 0) continue;
        const int odd = (o[0] != 0) + (o[1] != 0) + (o[2] != 0);
        if (odd == 0) coarse.pinned[size_t(n)] = fine.pinned[size_t(child)];
        inertia += fine.inertia[size_t(child)] / double(1 << odd);
      }
      coarse.inertia[size_t(n)] = inertia;
    }
  });
}

}  // namespace

void moduli_of_voxel(const Scene& scene, int64_t v, double k[6]) {
  const Material& m = scene.materials[size_t(scene.material(v))];
  const double fill = scene.grid.fill(v);
  k[0] = fill * m.mu();
  k[1] = fill * m.lambda();
  for (int j = 0; j < 4; ++j) k[2 + j] = fill * scene.variance(v, j);
  // without a variance term twelve modes of a voxel would have no energy in the cycle: it uses mu
  if (scene.hourglass == Hourglass::kOff)
    for (int j = 0; j < 4; ++j) k[2 + j] = fill * m.mu();
}

LevelGrid finest_level(const Scene& scene, double a0, std::shared_ptr<const BrickRows> rows) {
  const VoxelGrid& grid = scene.grid;
  LevelGrid level;
  level.rows = std::move(rows);
  level.nodes = grid.node_count();
  level.h = grid.h;
  level.moduli.resize(6 * size_t(grid.voxel_count()));
  for_each(grid.voxel_count(),
           [&](int64_t v) { moduli_of_voxel(scene, v, level.moduli.data() + 6 * v); });
  // masses, pins and coordinates
  level.inertia.resize(size_t(level.nodes));
  level.pinned.resize(size_t(level.nodes));
  level.node_coord = Array<int32_t>(level.nodes, 3);
  for_each(level.nodes, [&](int64_t n) {
    level.inertia[size_t(n)] = a0 * scene.mass(n) / (scene.dt * scene.dt);
    level.pinned[size_t(n)] = scene.pinned(n);
    std::copy_n(grid.node_coord.row(n), 3, level.node_coord.row(n));
  });
  // the unit of the operator, from its largest numbers
  level.unit = largest(level.nodes, [&](int64_t n) { return level.inertia[size_t(n)]; }) +
               largest(int64_t(level.moduli.size()), [&](int64_t k) {
                 return level.moduli[size_t(k)];
               }) * level.h;
  level.voxel_index = BrickIndex(grid.voxel_coord);
  level.node_index = BrickIndex(grid.node_coord);
  return level;
}

LevelGrid coarser_level(LevelGrid& fine) {
  LevelGrid coarse;
  coarse.voxel_index = fine.voxel_index.halved();
  coarse.node_index = coarse.voxel_index.corners();
  VoxelGrid grid = make_tables(coarse.voxel_index, coarse.node_index);
  coarse.rows =
      std::make_shared<const BrickRows>(make_brick_rows(grid, Array<int32_t>(grid.voxel_count())));
  coarse.nodes = grid.node_coord.rows();
  coarse.h = 2 * fine.h;
  coarse.unit = fine.unit;
  coarse.node_coord = std::move(grid.node_coord);
  coarse.inertia.resize(size_t(coarse.nodes));
  coarse.pinned.resize(size_t(coarse.nodes));
  average_moduli(fine, grid.voxel_coord, coarse);
  find_children(fine, coarse);
  find_parents(coarse, fine);
  return coarse;
}

void release_setup(LevelGrid& level) {
  level.moduli = {};
  level.voxel_index = level.node_index = {};
}

template <class T>
void restrict_residual(const LevelGrid& coarse_level, const T* fine, T* coarse) {
  constexpr T kWeight[4] = {1, T(0.5), T(0.25), T(0.125)};
  for_each(coarse_level.nodes, [&](int64_t n) {
    T sum[3] = {};
    if (!coarse_level.pinned[size_t(n)])
      for (int k = 0; k < 27; ++k) {
        const int64_t child = coarse_level.children[size_t(27 * n + k)];
        if (child < 0) continue;
        const T w = kWeight[(k % 3 != 1) + (k / 3 % 3 != 1) + (k / 9 != 1)];
        for (int i = 0; i < 3; ++i) sum[i] += w * fine[3 * child + i];
      }
    for (int i = 0; i < 3; ++i) coarse[3 * n + i] = sum[i];
  });
}

template <class T>
void prolong_correction(const LevelGrid& fine_level, const T* coarse, T* fine) {
  for_each(fine_level.nodes, [&](int64_t n) {
    if (fine_level.pinned[size_t(n)]) return;
    // mean over the parents that differ, two along each odd axis
    const int odd = odd_axes(fine_level.node_coord.row(n));
    T sum[3] = {};
    int corners = 0;
    for (int c = odd;; c = (c - 1) & odd) {
      ++corners;
      const int64_t parent = fine_level.parents[size_t(8 * n + c)];
      if (parent >= 0)
        for (int i = 0; i < 3; ++i) sum[i] += coarse[3 * parent + i];
      if (c == 0) break;
    }
    for (int i = 0; i < 3; ++i) fine[3 * n + i] += sum[i] / T(corners);
  });
}

template void restrict_residual(const LevelGrid&, const float*, float*);
template void restrict_residual(const LevelGrid&, const double*, double*);
template void prolong_correction(const LevelGrid&, const float*, float*);
template void prolong_correction(const LevelGrid&, const double*, double*);

}  // namespace elastogen
