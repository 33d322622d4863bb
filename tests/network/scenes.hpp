// SPDX-License-Identifier: Apache-2.0
// Scenes of the tests of network: full beams, bodies whose border voxels have sampled fills, ragged
// blocks with random fills.

#pragma once

#include "core/reduce.hpp"
#include "core/scene.hpp"
#include "core/state.hpp"
#include "network/potential/incremental_potential.hpp"
#include "voxelize/bricks.hpp"
#include "voxelize/slivers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace elastogen::test {

/// A solid by the numbers that the tests vary.
inline Material solid(double young, double poisson, Law law = Law::kNeoHookean,
                      double density = 1000) {
  return {.name = "test", .law = law, .young = young, .poisson = poisson, .density = density};
}

/// Scene on a grid with one material and nothing pinned; not finished.
inline Scene scene_on(VoxelGrid grid, const Material& material) {
  Scene scene;
  scene.grid = std::move(grid);
  scene.materials = {material};
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  return scene;
}

/// Pins the nodes with X_axis <= limit.
inline void pin_below(Scene& scene, int axis, double limit) {
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    if (scene.grid.rest(n, axis) <= limit) scene.pinned(n) = 1;
}

/// Young's modulus at which the Courant number (dt/h) sqrt(E/rho) is C.
inline double young_of_courant(double C, double h, double dt, double density = 1000) {
  return density * (C * h / dt) * (C * h / dt);
}

/// A full box of nx x ny x nz voxels, clamped at x = 0, under gravity; finished.
inline Scene clamped_beam(int nx, int ny, int nz, double h, const Material& material) {
  Scene scene = scene_on(make_box(nx, ny, nz, h), material);
  pin_below(scene, 0, h / 2);
  scene.gravity = {0, -9.81, 0};
  finish_scene(scene);
  return scene;
}

struct SampledVoxel {
  std::array<int32_t, 3> at;
  double fill, mean[8];
};

inline Array<int32_t> coordinates(const std::vector<SampledVoxel>& voxels) {
  Array<int32_t> coords(int64_t(voxels.size()), 3);
  for (size_t v = 0; v < voxels.size(); ++v)
    std::copy(voxels[v].at.begin(), voxels[v].at.end(), coords.row(int64_t(v)));
  return coords;
}

/// Voxels that the body meets, with fills and shape-function means from samples^3 points each.
/// @param inside        whether a point [m] lies in the body.
/// @param drop_slivers  leaves out the slivers of find_slivers; the floor of the fill is 0.02.
inline VoxelGrid sampled_grid(const Box& box, double h, int samples,
                              const std::function<bool(const Vec3&)>& inside, bool drop_slivers) {
  int lower[3], count[3];
  for (int d = 0; d < 3; ++d) {
    lower[d] = int(std::floor(box.lower[size_t(d)] / h));
    count[d] = int(std::ceil(box.upper[size_t(d)] / h)) - lower[d];
  }
  std::vector<SampledVoxel> voxels;
  for (int k = 0; k < count[2]; ++k)
    for (int j = 0; j < count[1]; ++j)
      for (int i = 0; i < count[0]; ++i) {
        SampledVoxel voxel = {{lower[0] + i, lower[1] + j, lower[2] + k}, 0, {}};
        for (int s = 0; s < samples * samples * samples; ++s) {
          const double t[3] = {(s % samples + 0.5) / samples,
                               (s / samples % samples + 0.5) / samples,
                               (s / samples / samples + 0.5) / samples};
          if (!inside(
                  {h * (voxel.at[0] + t[0]), h * (voxel.at[1] + t[1]), h * (voxel.at[2] + t[2])}))
            continue;
          voxel.fill += 1;
          for (int c = 0; c < 8; ++c)
            voxel.mean[c] +=
                (c & 1 ? t[0] : 1 - t[0]) * (c & 2 ? t[1] : 1 - t[1]) * (c & 4 ? t[2] : 1 - t[2]);
        }
        const double total = double(samples) * samples * samples;
        if (voxel.fill == 0) continue;
        for (double& mean : voxel.mean) mean /= voxel.fill;
        voxel.fill /= total;
        voxels.push_back(voxel);
      }

  Array<int32_t> coords = coordinates(voxels);
  if (drop_slivers) {
    Array<double> fill(coords.rows());
    for (int64_t v = 0; v < fill.rows(); ++v) fill(v) = voxels[size_t(v)].fill;
    const std::vector<uint8_t> gone = find_slivers(coords, fill);
    std::vector<SampledVoxel> left;
    for (size_t v = 0; v < voxels.size(); ++v)
      if (!gone[v]) left.push_back(voxels[v]);
    voxels = std::move(left);
    coords = coordinates(voxels);
  }
  VoxelGrid grid = make_grid(coords, h, {});
  // make_grid sorts: look each voxel up by its coordinate
  std::sort(voxels.begin(), voxels.end(), [](auto& a, auto& b) { return a.at < b.at; });
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    const std::array<int32_t, 3> at = {grid.voxel_coord(v, 0), grid.voxel_coord(v, 1),
                                       grid.voxel_coord(v, 2)};
    const auto voxel =
        std::lower_bound(voxels.begin(), voxels.end(), at,
                         [](const SampledVoxel& a, const auto& b) { return a.at < b; });
    if (voxel->fill == 1) continue;
    grid.fill(v) = std::max(voxel->fill, 0.02);
    std::copy(voxel->mean, voxel->mean + 8, grid.shape_mean.row(v));
  }
  return grid;
}

/// A ball of radius R about the origin.
inline VoxelGrid ball_grid(double R, double h, bool drop_slivers = false) {
  return sampled_grid(
      {{-R, -R, -R}, {R, R, R}}, h, 8,
      [=](const Vec3& p) { return p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < R * R; }, drop_slivers);
}

/// A bar of length L and square section, half width a, turned by 0.8 rad about (1, 2, 3), about the
/// origin.
inline VoxelGrid turned_bar_grid(double L, double a, double h, bool drop_slivers = false) {
  const double s = std::sin(0.8), c = 1 - std::cos(0.8), k = 1 / std::sqrt(14.0);
  const double axis[3] = {k, 2 * k, 3 * k};
  Mat3<double> R = identity<double>();
  const Mat3<double> K = {{0, -axis[2], axis[1], axis[2], 0, -axis[0], -axis[1], axis[0], 0}};
  const Mat3<double> K2 = K * K;
  for (int e = 0; e < 9; ++e) R.m[e] += s * K.m[e] + c * K2.m[e];
  const double half[3] = {L / 2, a, a};
  Box box;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p = {};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) p[size_t(i)] += R(i, j) * half[j] * (corner >> j & 1 ? 1 : -1);
    box.add(p);
  }
  return sampled_grid(
      box, h, 8,
      [=](const Vec3& p) {
        for (int j = 0; j < 3; ++j)
          if (std::abs(R(0, j) * p[0] + R(1, j) * p[1] + R(2, j) * p[2]) >= half[j]) return false;
        return true;
      },
      drop_slivers);
}

/// A block across brick borders with 15 % holes, random fills and shape means in half of its
/// voxels.
inline VoxelGrid ragged_grid(int nx, int ny, int nz, double h, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<std::array<int32_t, 3>> coords;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        if (uniform(random) > 0.15) coords.push_back({x - 3, y - 2, z - 1});
  Array<int32_t> list(int64_t(coords.size()), 3);
  for (size_t v = 0; v < coords.size(); ++v)
    std::copy(coords[v].begin(), coords[v].end(), list.row(int64_t(v)));
  VoxelGrid grid = make_grid(list, h, {0.3 * h, -0.7 * h, 0});
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    if (uniform(random) < 0.5) continue;
    // the fill is a box [t - w, t + w] of the voxel, per axis
    double t[3], fill = 1;
    for (double& centre : t) {
      const double half_width = 0.2 + 0.3 * uniform(random);
      centre = half_width + (1 - 2 * half_width) * uniform(random);
      fill *= 2 * half_width;
    }
    grid.fill(v) = fill;
    for (int c = 0; c < 8; ++c)
      grid.shape_mean(v, c) =
          (c & 1 ? t[0] : 1 - t[0]) * (c & 2 ? t[1] : 1 - t[1]) * (c & 4 ? t[2] : 1 - t[2]);
  }
  return grid;
}

/// Surface points of a full box: the four corner weights of every free voxel face, at its centre.
inline SurfacePoints face_points(const VoxelGrid& grid) {
  struct Point {
    int32_t voxel;
    int axis, side;
  };
  // faces that no other voxel shares
  std::vector<Point> points;
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    for (int d = 0; d < 3; ++d)
      for (int side = 0; side < 2; ++side) {
        const int bit = 1 << d;
        const int32_t corner = grid.corners(v, side ? bit : 0);
        if (grid.voxels(corner, side ? 0 : bit) < 0) points.push_back({int32_t(v), d, side});
      }
  // a point at the centre of each, with equal weights of its four corners
  SurfacePoints s;
  const int64_t count = int64_t(points.size());
  s.voxel = Array<int32_t>(count);
  s.weights = Array<double>(count, 8);
  s.area = Array<double>(count);
  s.position = Array<double>(count, 3);
  for (int64_t p = 0; p < count; ++p) {
    const auto [voxel, axis, side] = points[size_t(p)];
    s.voxel(p) = voxel;
    s.area(p) = grid.h * grid.h;
    for (int c = 0; c < 8; ++c) {
      if ((c >> axis & 1) != side) continue;
      s.weights(p, c) = 0.25;
      for (int i = 0; i < 3; ++i) s.position(p, i) += grid.rest(grid.corners(voxel, c), i) / 4;
    }
  }
  return s;
}

/// Random displacements of the nodes, uniform in +-size, 0 on pinned ones.
inline std::vector<double> random_field(const Scene& scene, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  std::vector<double> field(3 * size_t(scene.grid.node_count()));
  for (size_t k = 0; k < field.size(); ++k) {
    const double value = uniform(random);
    field[k] = scene.pinned(int64_t(k / 3)) ? 0 : value;
  }
  return field;
}

inline std::vector<double> displacement(const Scene& scene, const State& state) {
  std::vector<double> u(size_t(state.x.size()));
  for (size_t k = 0; k < u.size(); ++k) u[k] = state.x.data()[k] - scene.grid.rest.data()[k];
  return u;
}

inline double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

inline double norm(const std::vector<double>& a) {
  return std::sqrt(dot(a, a));
}

/// |a - b| / |b|
template <class A, class B>
double relative_difference(const A& a, const B& b) {
  double difference = 0, size = 0;
  for (size_t k = 0; k < size_t(b.size()); ++k) {
    difference +=
        (double(a.data()[k]) - double(b.data()[k])) * (double(a.data()[k]) - double(b.data()[k]));
    size += double(b.data()[k]) * double(b.data()[k]);
  }
  return std::sqrt(difference / size);
}

}  // namespace elastogen::test
