// SPDX-License-Identifier: Apache-2.0
// Bodies that can turn or slide as a whole, though something holds them: on an edge or a point that
// is cut out of voxels, or along an axis.

#pragma once

#include "tests/network/fixed_scenes.hpp"
#include "tests/network/step/motion_scenes.hpp"

namespace elastogen::test {

/// A body that hangs on a border, let go where gravity is turned by an angle about z.
inline MovingScene hung(Scene scene, double young, double angle) {
  scene.materials[0] = solid(young, 0.4);
  scene.gravity = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
  scene.dt = kFrame;
  finish_scene(scene);
  MovingScene m{std::move(scene), {}};
  m.start = initial_state(m.scene);
  return m;
}

/// The pendulum of motion_scenes.hpp, or one of other voxels, on an edge of 0.2 x 0.2 mm that its pin
/// cuts out of voxels.
inline MovingScene pendulum_on_cut_edge(double angle, double h = 0.05, double courant = 50) {
  constexpr double kAside = 1e-4;
  Border edge;
  edge.lower = {-kAside, 0.4 - kAside, -1};
  edge.upper = {kAside, 0.4 + kAside, 1};
  const double depth = h < 0.07 ? 0.15 : 0.2;
  return hung(held_scene(box_surface({0, 0, 0}, {0.2, 0.4, depth}), {edge}, h, {}),
              young_of_frame(courant, h), angle);
}

/// A block on a small ball at one of its corners, which also turns about the axis through it.
inline MovingScene block_on_a_corner(double angle, double h = 0.05, double courant = 50) {
  MovingScene m = hung(
      held_scene(box_surface({0, 0, 0}, {0.2, 0.3, 0.2}), {ball_border({0, 0.3, 0}, 1e-3)}, h, {}),
      young_of_frame(courant, h), angle);
  for (int64_t n = 0; n < m.start.v.rows(); ++n) {
    const double* X = m.scene.grid.rest.row(n);
    m.start.v(n, 0) = 3 * X[2];
    m.start.v(n, 2) = -3 * X[0];
  }
  m.scene.dependent.fill(m.start.v.data());
  return m;
}

/// A box that is thrown and spins about x, or its half from x = 0 on, which is held along x in that
/// plane of symmetry.
inline MovingScene thrown_box(bool half) {
  const double h = 0.05;
  MovingScene m{scene_on(make_box(half ? 3 : 6, 4, 3, h), solid(young_of_frame(20, h), 0.3)), {}};
  m.scene.gravity = {0, -9.81, 2};
  finish_scene(m.scene);
  if (half) fix_plane(m.scene, 0, 0);
  m.start = initial_state(m.scene, {.velocity = {0, 3, 1}, .spin = {10, 0, 0}});
  return m;
}

}  // namespace elastogen::test
