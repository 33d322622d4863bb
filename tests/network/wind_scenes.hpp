// SPDX-License-Identifier: Apache-2.0
// Light boxes in wind (core/loads.hpp).

#pragma once

#include "tests/network/held_scenes.hpp"

namespace elastogen::test {

inline bool is_left_out(const Vec3&) {
  return false;
}

/// A closed box in air of a constant velocity, without weight.
inline Scene box_in_wind(const Vec3& lower, const Vec3& upper, double h, const Vec3& velocity) {
  const Surface surface = box_surface(lower, upper);
  Scene scene = scene_on(voxelize(surface, {.h = h}).grid, solid(1e6, 0.3));
  scene.materials[0].density = 30;
  scene.dt = 1.0 / 60;
  scene.wind.velocity = {{0, velocity}};
  add_wind_surface(scene.grid, surface, is_left_out, scene.wind);
  finish_scene(scene);
  return scene;
}

/// A light strip along x, held at its left end on a grid that fits, in wind along y.
inline Scene strip_in_wind(double density, double speed) {
  Scene scene = box_in_wind({0, 0, 0}, {0.6, 0.1, 0.2}, 0.1, {0, speed, 0});
  scene.materials[0].density = density;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    if (scene.grid.rest(n, 0) < 1e-6) scene.pinned(n) = kPinnedNode;
  scene.holders.resize(1);
  scene.holder = Array<int32_t>(scene.grid.node_count());
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    scene.holder(n) = scene.pinned(n) == kPinnedNode ? 0 : -1;
  finish_scene(scene);
  return scene;
}

/// The same under a force that swells and fades, in gusts, with what its left end holds turned.
inline Scene strip_in_gusts(TimeScheme scheme) {
  Scene scene = strip_in_wind(20, 8);
  scene.scheme = scheme;
  scene.wind.velocity = {{0, {2, 5, 0}}, {0.1, {0, 12, 3}}, {0.2, {}}};
  scene.holders[0].turns = true;
  scene.holders[0].path = {{0, {}}, {0.2, {0.5, 0, 0}}};
  scene.holders[0].path.eases = true;
  TimedForce& force = scene.forces.emplace_back();
  force.force = {{0, {}}, {0.07, {0, 0.1, 0.3}}, {0.15, {}}};
  force.share = Array<double>(scene.grid.node_count());
  double whole = 0;
  for (int64_t n = 0; n < scene.mass.rows(); ++n) whole += scene.mass(n);
  for (int64_t n = 0; n < scene.mass.rows(); ++n) force.share(n) = scene.mass(n) / whole;
  finish_scene(scene);
  return scene;
}

}  // namespace elastogen::test
