// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline_scene.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <vector>

namespace elastogen::bench {
namespace {

/// The box of the grid's voxels as a dense array.
struct Dense {
  std::array<int64_t, 3> lower = {INT64_MAX, INT64_MAX, INT64_MAX}, dims = {};

  explicit Dense(const VoxelGrid& grid) {
    std::array<int64_t, 3> upper = {INT64_MIN, INT64_MIN, INT64_MIN};
    for (int64_t v = 0; v < grid.voxel_count(); ++v)
      for (int d = 0; d < 3; ++d) {
        lower[size_t(d)] = std::min<int64_t>(lower[size_t(d)], grid.voxel_coord(v, d));
        upper[size_t(d)] = std::max<int64_t>(upper[size_t(d)], grid.voxel_coord(v, d));
      }
    for (size_t d = 0; d < 3; ++d) dims[d] = upper[d] - lower[d] + 1;
  }

  /// Index of a lattice point in an array of dims + more.
  size_t place(const int32_t* coord, int64_t more) const {
    return size_t(coord[0] - lower[0] +
                  (dims[0] + more) *
                      (coord[1] - lower[1] + (dims[1] + more) * (coord[2] - lower[2])));
  }
  size_t size(int64_t more) const {
    return size_t((dims[0] + more) * (dims[1] + more) * (dims[2] + more));
  }
};

void check(const Scene& scene, const Dense& dense) {
  const VoxelGrid& grid = scene.grid;
  const Material& m = scene.materials[0];
  const bool full = std::all_of(grid.fill.data(), grid.fill.data() + grid.fill.size(),
                                [](double fill) { return fill == 1; });
  ELASTOGEN_CHECK(full && scene.materials.size() == 1 && m.law == Law::kNeoHookean &&
                      scene.hourglass == Hourglass::kVariance,
                  "the baseline takes full voxels of one neo-Hookean material with the variance "
                  "term");
  for (const int64_t n : dense.dims)
    ELASTOGEN_CHECK(n >= 2, "the baseline takes bodies of two voxels or more along each axis");
}

template <class T>
std::string_view bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

nlohmann::ordered_json header(const Scene& scene, const Dense& dense, const PaperLoops& loops) {
  const Material& m = scene.materials[0];
  return {{"dims", dense.dims},       {"h", scene.grid.h},    {"dt", scene.dt},
          {"young", m.young},         {"poisson", m.poisson}, {"density", m.density},
          {"gravity", scene.gravity}, {"outer", loops.outer}, {"inner", loops.inner},
          {"modes", loops.modes}};
}

}  // namespace

void write_baseline_scene(const std::string& folder, const Scene& scene, const State& state,
                          const PaperLoops& loops) {
  const VoxelGrid& grid = scene.grid;
  const Dense dense(grid);
  check(scene, dense);
  std::vector<uint8_t> solid(dense.size(0)), pinned(dense.size(1));
  std::vector<double> u(3 * dense.size(1)), v(u.size());
  for (int64_t k = 0; k < grid.voxel_count(); ++k)
    solid[dense.place(grid.voxel_coord.row(k), 0)] = 1;
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    const size_t place = dense.place(grid.node_coord.row(n), 1);
    pinned[place] = scene.pinned(n);
    for (int d = 0; d < 3; ++d) {
      u[3 * place + size_t(d)] = state.x(n, d) - grid.rest(n, d);
      v[3 * place + size_t(d)] = state.v(n, d);
    }
  }
  write_file(folder + "/scene.json", header(scene, dense, loops).dump(1) + "\n");
  write_file(folder + "/solid.u8", bytes(solid));
  write_file(folder + "/pinned.u8", bytes(pinned));
  write_file(folder + "/u.f64", bytes(u));
  write_file(folder + "/v.f64", bytes(v));
}

Array<double> read_baseline_positions(const std::string& folder, const Scene& scene) {
  const VoxelGrid& grid = scene.grid;
  const Dense dense(grid);
  const std::string path = folder + "/u.f64", content = read_file(path);
  std::vector<double> u(3 * dense.size(1));
  ELASTOGEN_CHECK_ASSET(content.size() == u.size() * sizeof(double), path, " has ", content.size(),
                        " bytes, not ", u.size() * sizeof(double));
  std::memcpy(u.data(), content.data(), content.size());
  Array<double> x(grid.node_count(), 3);
  for (int64_t n = 0; n < grid.node_count(); ++n)
    for (int d = 0; d < 3; ++d)
      x(n, d) = grid.rest(n, d) + u[3 * dense.place(grid.node_coord.row(n), 1) + size_t(d)];
  return x;
}

}  // namespace elastogen::bench
