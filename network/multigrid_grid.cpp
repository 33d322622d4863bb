// SPDX-License-Identifier: Apache-2.0
#include "network/multigrid_grid.hpp"

#include "core/error.hpp"
#include "voxelize/bricks.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace elastogen {
namespace {

using Coord = std::array<int32_t, 3>;

uint64_t key(int32_t x, int32_t y, int32_t z) {
  const auto part = [](int32_t a) { return uint64_t(uint32_t(a + (1 << 20))) & 0x1fffff; };
  return part(x) << 42 | part(y) << 21 | part(z);
}

/// Index of each lattice coordinate, (items, 3), by its key.
class CoordIndex {
 public:
  explicit CoordIndex(const Array<int32_t>& coord) : keys_(size_t(coord.rows())) {
    for (int64_t i = 0; i < coord.rows(); ++i)
      keys_[size_t(i)] = {key(coord(i, 0), coord(i, 1), coord(i, 2)), int32_t(i)};
    std::sort(keys_.begin(), keys_.end());
  }
  int32_t find(int32_t x, int32_t y, int32_t z) const {
    const std::pair<uint64_t, int32_t> wanted(key(x, y, z), -1);
    const auto at = std::lower_bound(keys_.begin(), keys_.end(), wanted);
    return at != keys_.end() && at->first == wanted.first ? at->second : -1;
  }

 private:
  std::vector<std::pair<uint64_t, int32_t>> keys_;
};

/// The voxels of twice the edge that hold a voxel of the fine level, each once.
Array<int32_t> coarse_voxels(const Array<int32_t>& fine) {
  std::vector<Coord> coords;
  for (int64_t v = 0; v < fine.rows(); ++v)
    coords.push_back({fine(v, 0) >> 1, fine(v, 1) >> 1, fine(v, 2) >> 1});
  std::sort(coords.begin(), coords.end());
  coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
  Array<int32_t> result(int64_t(coords.size()), 3);
  for (size_t v = 0; v < coords.size(); ++v)
    std::copy(coords[v].begin(), coords[v].end(), result.row(int64_t(v)));
  return result;
}

/// Means of the eight children, empty ones counted as 0; one variance weight for all patterns.
void average_moduli(const LevelGrid& fine, LevelGrid& coarse) {
  const CoordIndex index(coarse.voxel_coord);
  coarse.moduli.resize(6 * size_t(coarse.voxel_coord.rows()));
  for (int64_t v = 0; v < fine.voxel_coord.rows(); ++v) {
    const int32_t parent = index.find(fine.voxel_coord(v, 0) >> 1, fine.voxel_coord(v, 1) >> 1,
                                      fine.voxel_coord(v, 2) >> 1);
    const double* k = fine.moduli.data() + 6 * v;
    double* sum = coarse.moduli.data() + 6 * parent;
    sum[0] += k[0] / 8;
    sum[1] += k[1] / 8;
    const double variance = (k[2] + k[3] + k[4] + k[5]) / 4;
    for (int j = 2; j < 6; ++j) sum[j] += variance / 8;
  }
}

/// Parents of the fine nodes, children and masses of the coarse ones.
void connect(LevelGrid& fine, LevelGrid& coarse) {
  const CoordIndex coarse_index(coarse.node_coord), fine_index(fine.node_coord);
  fine.parents.resize(8 * size_t(fine.nodes));
  for_each(fine.nodes, [&](int64_t n) {
    const int32_t* at = fine.node_coord.row(n);
    for (int c = 0; c < 8; ++c) {
      // an even coordinate has one parent, an odd one the two beside it
      int32_t q[3];
      for (int d = 0; d < 3; ++d) q[d] = (at[d] + (c >> d & 1 ? at[d] & 1 : 0)) >> 1;
      const int32_t parent = coarse_index.find(q[0], q[1], q[2]);
      fine.parents[size_t(8 * n + c)] = coarse.pinned[size_t(parent)] ? -1 : parent;
    }
  });
  coarse.children.resize(27 * size_t(coarse.nodes));
  for_each(coarse.nodes, [&](int64_t n) {
    const int32_t* at = coarse.node_coord.row(n);
    double inertia = 0;
    for (int k = 0; k < 27; ++k) {
      const int o[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
      const int32_t child = fine_index.find(2 * at[0] + o[0], 2 * at[1] + o[1], 2 * at[2] + o[2]);
      coarse.children[size_t(27 * n + k)] = child;
      if (child < 0) continue;
      const int odd = (o[0] != 0) + (o[1] != 0) + (o[2] != 0);
      inertia += fine.inertia[size_t(child)] / double(1 << odd);
    }
    coarse.inertia[size_t(n)] = inertia;
  });
}

}  // namespace

LevelGrid finest_level(const Scene& scene, double a0) {
  const VoxelGrid& grid = scene.grid;
  LevelGrid level;
  level.rows = make_brick_rows(grid, scene.material);
  level.nodes = grid.node_count();
  level.h = grid.h;
  level.corners.assign(grid.corners.data(), grid.corners.data() + grid.corners.size());
  level.shape_mean.assign(grid.shape_mean.data(), grid.shape_mean.data() + grid.shape_mean.size());
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
  coarse.corners.assign(grid.corners.data(), grid.corners.data() + grid.corners.size());
  coarse.voxel_coord = grid.voxel_coord;
  coarse.node_coord = grid.node_coord;
  coarse.inertia.resize(size_t(coarse.nodes));
  coarse.pinned.resize(size_t(coarse.nodes));
  const CoordIndex fine_index(fine.node_coord);
  for (int64_t n = 0; n < coarse.nodes; ++n) {
    const int32_t* at = grid.node_coord.row(n);
    const int32_t same = fine_index.find(2 * at[0], 2 * at[1], 2 * at[2]);
    coarse.pinned[size_t(n)] = same >= 0 && fine.pinned[size_t(same)];
  }
  average_moduli(fine, coarse);
  connect(fine, coarse);
  return coarse;
}

void release_setup(LevelGrid& level) {
  level.corners = {};
  level.moduli = {};
  level.shape_mean = {};
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
