// SPDX-License-Identifier: Apache-2.0
// Scenes for whole steps on the device.

#pragma once

#include "network/step/step_work.hpp"
#include "tests/network/scenes.hpp"
#include "tests/support/on_card.hpp"

namespace elastogen::test {

/// A clamped beam of two materials over several bricks, at Courant number 8.
inline Scene beam_of_regions(TimeScheme scheme) {
  const double h = 0.025, dt = 1.0 / 60;
  Scene scene = scene_on(make_box(24, 5, 7, h), solid(young_of_courant(8, h, dt), 0.4));
  scene.materials.push_back(solid(young_of_courant(4, h, dt, 700), 0.3, Law::kFixedCorotated, 700));
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    scene.material(v) = scene.grid.voxel_coord(v, 0) > 11;
  pin_below(scene, 0, h / 2);
  scene.gravity = {0, -9.81, 0};
  scene.scheme = scheme;
  finish_scene(scene);
  return scene;
}

/// A bar that falls, of border voxels.
inline Scene falling_bar(TimeScheme scheme) {
  Scene scene = scene_on(turned_bar_grid(0.5, 0.07, 0.025), solid(4e4, 0.4));
  scene.gravity = {0, -9.81, 0};
  scene.scheme = scheme;
  finish_scene(scene);
  return scene;
}

/// Three blocks beside each other, the second pinned on one side, the first of more nodes than one
/// chunk of the device's sums over pieces.
inline Scene three_blocks(TimeScheme scheme) {
  constexpr int kSize[3][3] = {{12, 11, 10}, {7, 4, 4}, {5, 4, 6}};
  std::vector<std::array<int32_t, 3>> coords;
  for (int p = 0; p < 3; ++p)
    for (int z = 0; z < kSize[p][2]; ++z)
      for (int y = 0; y < kSize[p][1]; ++y)
        for (int x = 0; x < kSize[p][0]; ++x) coords.push_back({x, 16 * p + y, z});
  Array<int32_t> list(int64_t(coords.size()), 3);
  for (size_t v = 0; v < coords.size(); ++v)
    std::copy(coords[v].begin(), coords[v].end(), list.row(int64_t(v)));
  Scene scene = scene_on(make_grid(list, 0.02, {}), solid(2e4, 0.35));
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const int y = scene.grid.node_coord(n, 1);
    scene.pinned(n) = y >= 16 && y <= 20 && scene.grid.node_coord(n, 0) == 0;
  }
  scene.gravity = {0, -9.81, 0};
  scene.scheme = scheme;
  finish_scene(scene);
  return scene;
}

/// |x_a - x_b| over the displacement of b from rest.
inline double distance_of_ways(const Scene& scene, const State& a, const State& b) {
  return relative_difference(displacement(scene, a), displacement(scene, b));
}

}  // namespace elastogen::test
