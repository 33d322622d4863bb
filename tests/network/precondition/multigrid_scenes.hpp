// SPDX-License-Identifier: Apache-2.0
// Scenes that the multigrid of the device is compared on with that of the CPU: blocks, border
// voxels, materials, pins, sheets, dust, over several bricks and on both sides of the origin.

#pragma once

#include "tests/network/scenes.hpp"

#include <string>

namespace elastogen::test {

struct NamedScene {
  std::string name;
  Scene scene;
};

/// A block over several bricks of two materials with holes and random fills, pinned on one side.
inline Scene ragged_of_two_materials(int nx, int ny, int nz) {
  constexpr double kEdge = 0.02;
  Scene scene = scene_on(ragged_grid(nx, ny, nz, kEdge, 3), solid(3e4, 0.4));
  scene.materials.push_back(solid(8e4, 0.3, Law::kNeoHookean, 700));
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    scene.material(v) = scene.grid.voxel_coord(v, 1) > 3;
  pin_below(scene, 0, -1.5 * kEdge);
  finish_scene(scene);
  return scene;
}

/// A full box whose first voxel is at `first`.
inline Scene box_at(const std::array<int32_t, 3>& first, int nx, int ny, int nz) {
  Array<int32_t> coords(int64_t(nx) * ny * nz, 3);
  for (int64_t v = 0; v < coords.rows(); ++v) {
    coords(v, 0) = first[0] + int32_t(v % nx);
    coords(v, 1) = first[1] + int32_t(v / nx % ny);
    coords(v, 2) = first[2] + int32_t(v / nx / ny);
  }
  Scene scene = scene_on(make_grid(coords, 0.1, {}), solid(1e5, 0.45));
  finish_scene(scene);
  return scene;
}

/// Voxels that touch in edges, corners or nowhere: coarsening soon stops, or the last level is
/// dense on more bricks than nodes would fill.
inline Scene dust(int per_axis, int apart) {
  std::vector<std::array<int32_t, 3>> list;
  for (int k = 0; k < per_axis * per_axis * per_axis; ++k)
    list.push_back({apart * (k % per_axis), apart * (k / per_axis % per_axis),
                    apart * (k / per_axis / per_axis)});
  list.push_back({1, 1, 0});
  list.push_back({2, 2, 1});
  Array<int32_t> coords(int64_t(list.size()), 3);
  for (size_t v = 0; v < list.size(); ++v)
    std::copy(list[v].begin(), list[v].end(), coords.row(int64_t(v)));
  Scene scene = scene_on(make_grid(coords, 0.1, {}), solid(1e5, 0.3));
  finish_scene(scene);
  return scene;
}

inline std::vector<NamedScene> multigrid_scenes() {
  Scene ball = scene_on(ball_grid(0.2, 0.02), solid(5e4, 0.3));
  finish_scene(ball);
  Scene plate = box_at({-5, 3, 7}, 40, 33, 1);
  pin_below(plate, 1, 0.35);
  finish_scene(plate);
  return {{"block", clamped_beam(40, 9, 17, 0.02, solid(1e5, 0.45))},
          {"block of one brick's nodes", box_at({0, 0, 0}, 7, 7, 7)},
          {"block across the origin", box_at({-9, -8, -1}, 18, 17, 16)},
          {"ball", ball},
          {"two materials", ragged_of_two_materials(19, 13, 11)},
          {"two materials, large", ragged_of_two_materials(50, 26, 37)},
          {"plate", plate},
          {"voxel", box_at({7, -1, 15}, 1, 1, 1)},
          {"two voxels", box_at({7, 0, 0}, 2, 1, 1)},
          {"dust", dust(5, 3)},
          {"sparse dust", dust(2, 20)},
          {"much dust", dust(6, 9)}};
}

/// A stiffness on some nodes and components, as contact adds it.
inline std::vector<double> some_stiffness(const Scene& scene) {
  std::vector<double> stiffness(3 * size_t(scene.grid.node_count()));
  for (size_t k = 0; k < stiffness.size(); k += 7)
    if (!scene.pinned(int64_t(k / 3))) stiffness[k] = 100 + double(k % 11);
  return stiffness;
}

}  // namespace elastogen::test
