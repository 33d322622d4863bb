// SPDX-License-Identifier: Apache-2.0
#include "bench/scenes.hpp"

#include "core/error.hpp"
#include "voxelize/bricks.hpp"
#include "voxelize/demo_character.hpp"
#include "voxelize/voxelize.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace elastogen::bench {
namespace {

constexpr double kDensity = 1000, kStep = 1.0 / 60;

Scene finish(VoxelGrid&& grid, const SceneOptions& o, int pinned_axis, double pinned_below) {
  Scene scene;
  scene.grid = std::move(grid);
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    scene.pinned(n) = scene.grid.rest(n, pinned_axis) <= pinned_below;
  scene.gravity = {0, -9.81, 0};
  scene.dt = kStep;
  scene.hourglass = o.hourglass;
  const double speed = o.courant * scene.grid.h / kStep;
  scene.materials = {{"bench", o.law, kDensity * speed * speed, o.poisson, kDensity}};
  finish_scene(scene);
  return scene;
}

bool inside_ball(double x, double y, double z) {
  constexpr double kWave = 25;  // [rad/m]
  return x * x + y * y + z * z < 0.25 &&
         std::sin(kWave * x) * std::sin(kWave * y) * std::sin(kWave * z) < 0.35;
}

/// Fill and shape-function means of a voxel by 4^3 samples.
double sample_voxel(const double corner[3], double h, double mean[8]) {
  constexpr int kSamples = 4;
  double inside = 0;
  std::fill(mean, mean + 8, 0);
  for (int s = 0; s < kSamples * kSamples * kSamples; ++s) {
    const double t[3] = {(s % 4 + 0.5) / 4, (s / 4 % 4 + 0.5) / 4, (s / 16 + 0.5) / 4};
    if (!inside_ball(corner[0] + h * t[0], corner[1] + h * t[1], corner[2] + h * t[2])) continue;
    ++inside;
    for (int c = 0; c < 8; ++c)
      mean[c] += (c & 1 ? t[0] : 1 - t[0]) * (c & 2 ? t[1] : 1 - t[1]) * (c & 4 ? t[2] : 1 - t[2]);
  }
  for (int c = 0; c < 8; ++c) mean[c] = inside > 0 ? mean[c] / inside : 0.125;
  return inside / (kSamples * kSamples * kSamples);
}

}  // namespace

Scene cantilever(const SceneOptions& o) {
  const int n = std::max(1, int(std::lround(std::cbrt(o.voxels / 4))));
  return finish(make_box(4 * n, n, n, 1.0 / (4 * n)), o, 0, 1e-9);
}

Scene porous_ball(const SceneOptions& o) {
  const int n = int(std::lround(std::cbrt(o.voxels / 0.44)));
  const double h = 1.0 / n;
  std::vector<int32_t> coords;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const double corner[3] = {x * h - 0.5, y * h - 0.5, z * h - 0.5};
        double mean[8];
        if (sample_voxel(corner, h, mean) >= 0.05) coords.insert(coords.end(), {x, y, z});
      }
  Array<int32_t> voxels(int64_t(coords.size()) / 3, 3);
  std::copy(coords.begin(), coords.end(), voxels.data());
  VoxelGrid grid = make_grid(voxels, h, {-0.5, -0.5, -0.5});
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    const double corner[3] = {grid.voxel_coord(v, 0) * h - 0.5, grid.voxel_coord(v, 1) * h - 0.5,
                              grid.voxel_coord(v, 2) * h - 0.5};
    double mean[8];
    const double fill = sample_voxel(corner, h, mean);
    grid.fill(v) = fill;
    if (fill < 1) std::copy(mean, mean + 8, grid.shape_mean.row(v));
  }
  return finish(std::move(grid), o, 1, -0.5 + 0.12);
}

BenchScene spinning_bar(const SceneOptions& o) {
  const int n = std::max(1, int(std::lround(std::cbrt(o.voxels / 4))));
  BenchScene bar;
  bar.scene = finish(make_box(4 * n, n, n, 1.0 / (4 * n)), o, 0, -1);
  bar.scene.gravity = {};
  bar.motion.spin[2] = 0.4 / kStep;
  return bar;
}

Scene character(const SceneOptions& o) {
  const Surface surface = pose_surface(demo_character());
  // the body fills about a tenth of the cube over its longest edge
  const int along = std::max(8, int(std::lround(std::cbrt(10 * o.voxels))));
  Voxelized voxelized = voxelize(surface, {.voxels = along});
  return finish(std::move(voxelized.grid), o, 0,
                surface.box.lower[0] + 0.03 * surface.box.extent(0));
}

BenchScene bench_scene(const std::string& name, const SceneOptions& options) {
  if (name == "beam") return {cantilever(options), {}};
  if (name == "ball") return {porous_ball(options), {}};
  if (name == "bar") return spinning_bar(options);
  if (name == "character") return {character(options), {}};
  throw Error(concat("unknown scene '", name, "'; known are beam, ball, bar, character"));
}

}  // namespace elastogen::bench
