// SPDX-License-Identifier: Apache-2.0
#include "network/multigrid_grid.hpp"

#include "core/parallel.hpp"
#include "voxelize/brick_index.hpp"
#include "voxelize/bricks.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// Looks lattice points up that mostly lie in the brick of the one before.
class Lookup {
 public:
  explicit Lookup(const BrickIndex& index) : index_(index) {}
  /// Number of the point, -1 if it is not there.
  int32_t operator()(int32_t x, int32_t y, int32_t z) {
    const uint64_t key = brick_key({x, y, z});
    if (key >> 9 != brick_) {
      brick_ = key >> 9;
      place_ = index_.find_brick(brick_);
    }
    return place_ < 0 ? -1 : int32_t(index_.find(place_, int(key & 511)));
  }

 private:
  const BrickIndex& index_;
  uint64_t brick_ = ~uint64_t{0};
  int64_t place_ = -1;
};

/// The voxels of twice the edge that hold a voxel of the fine level, each once.
Array<int32_t> coarse_voxels(const Array<int32_t>& fine) {
  Array<int32_t> halves(fine.rows(), 3);
  for_each(fine.size(), [&](int64_t k) { halves.data()[k] = fine.data()[k] >> 1; });
  return BrickIndex(halves).points();
}

/// Means of the eight children, empty ones counted as 0; one variance weight for all patterns.
void average_moduli(const LevelGrid& fine, LevelGrid& coarse) {
  const BrickIndex index(fine.voxel_coord);
  const int64_t voxels = coarse.voxel_coord.rows();
  coarse.moduli.resize(6 * size_t(voxels));
  for_blocks(voxels, [&](int64_t begin, int64_t end) {
    Lookup find(index);
    for (int64_t v = begin; v < end; ++v) {
      const int32_t* at = coarse.voxel_coord.row(v);
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

/// Parents of the fine nodes.
void find_parents(const BrickIndex& coarse_index, const LevelGrid& coarse, LevelGrid& fine) {
  fine.parents.resize(8 * size_t(fine.nodes));
  for_blocks(fine.nodes, [&](int64_t begin, int64_t end) {
    Lookup find(coarse_index);
    for (int64_t n = begin; n < end; ++n) {
      const int32_t* at = fine.node_coord.row(n);
      for (int c = 0; c < 8; ++c) {
        // an even coordinate has one parent, an odd one the two beside it
        int32_t q[3];
        for (int d = 0; d < 3; ++d) q[d] = (at[d] + (c >> d & 1 ? at[d] & 1 : 0)) >> 1;
        const int32_t parent = find(q[0], q[1], q[2]);
        fine.parents[size_t(8 * n + c)] = coarse.pinned[size_t(parent)] ? -1 : parent;
      }
    }
  });
}

/// Children and masses of the coarse nodes; those on a pinned node are pinned.
void find_children(const BrickIndex& fine_index, const LevelGrid& fine, LevelGrid& coarse) {
  coarse.children.resize(27 * size_t(coarse.nodes));
  for_blocks(coarse.nodes, [&](int64_t begin, int64_t end) {
    Lookup find(fine_index);
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

LevelGrid finest_level(const Scene& scene, double a0) {
  const VoxelGrid& grid = scene.grid;
  LevelGrid level;
  level.rows = make_brick_rows(grid, scene.material);
  level.nodes = grid.node_count();
  level.h = grid.h;
  level.moduli.resize(6 * size_t(grid.voxel_count()));
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    const Material& m = scene.materials[size_t(scene.material(v))];
    double* k = level.moduli.data() + 6 * v;
    k[0] = grid.fill(v) * m.mu();
    k[1] = grid.fill(v) * m.lambda();
    for (int j = 0; j < 4; ++j) k[2 + j] = grid.fill(v) * scene.variance(v, j);
    // without the variance term the cycle could not see twelve modes of a voxel: it keeps its own
    if (scene.hourglass == Hourglass::kOff)
      for (int j = 0; j < 4; ++j) k[2 + j] = grid.fill(v) * m.mu();
  }
  level.inertia.resize(size_t(level.nodes));
  for (int64_t n = 0; n < level.nodes; ++n)
    level.inertia[size_t(n)] = a0 * scene.mass(n) / (scene.dt * scene.dt);
  level.unit = *std::max_element(level.inertia.begin(), level.inertia.end()) +
               *std::max_element(level.moduli.begin(), level.moduli.end()) * level.h;
  level.pinned.assign(scene.pinned.data(), scene.pinned.data() + level.nodes);
  level.voxel_coord = grid.voxel_coord;
  level.node_coord = grid.node_coord;
  return level;
}

LevelGrid coarser_level(LevelGrid& fine) {
  const VoxelGrid grid = make_grid(coarse_voxels(fine.voxel_coord), 2 * fine.h, {});
  LevelGrid coarse;
  coarse.rows = make_brick_rows(grid, Array<int32_t>(grid.voxel_count()));
  coarse.nodes = grid.node_count();
  coarse.h = 2 * fine.h;
  coarse.unit = fine.unit;
  coarse.voxel_coord = grid.voxel_coord;
  coarse.node_coord = grid.node_coord;
  coarse.inertia.resize(size_t(coarse.nodes));
  coarse.pinned.resize(size_t(coarse.nodes));
  average_moduli(fine, coarse);
  find_children(BrickIndex(fine.node_coord), fine, coarse);
  find_parents(BrickIndex(coarse.node_coord), coarse, fine);
  return coarse;
}

void release_setup(LevelGrid& level) {
  level.moduli = {};
  level.voxel_coord = {};
  level.rows.slot = {};
  level.rows.voxel = {};
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
    // the corners that differ: those along the odd axes
    const int32_t* at = fine_level.node_coord.row(n);
    const int odd = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
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
