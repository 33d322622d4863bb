// SPDX-License-Identifier: Apache-2.0
// Soft bodies in motion that are held at borders that cut voxels (held_scenes.hpp).

#pragma once

#include "tests/network/held_scenes.hpp"

#include <cmath>
#include <numbers>

namespace elastogen::test {

inline constexpr double kHeldEdge = 0.05;  // of voxels [m]

/// A soft bar of 1 x 0.2 x 0.2 m, held at both ends by borders that cut its voxels; the first one
/// lies an offset [voxels] behind a layer of nodes.
inline Scene swinging_bar(TimeScheme scheme, double offset = 0.7) {
  Scene scene = held_scene(box_surface({0, 0, 0}, {1, 0.2, 0.2}),
                           {half_space_border(true, 0.01), half_space_border(false, 0.99)},
                           kHeldEdge, {0.01 - offset * kHeldEdge, 0.02, 0.02}, 1.0 / 60);
  scene.materials[0] = solid(2e5, 0.3);
  scene.scheme = scheme;
  finish_scene(scene);
  return scene;
}

/// A soft block on a ball inside of it.
inline Scene block_on_ball(TimeScheme scheme) {
  Scene scene =
      held_scene(box_surface({0, 0, 0}, {0.6, 0.6, 0.6}), {ball_border({0.3, 0.3, 0.3}, 0.17)},
                 0.04, {0.01, 0.02, 0.03}, 1.0 / 60);
  scene.materials[0] = solid(1e5, 0.4);
  scene.scheme = scheme;
  finish_scene(scene);
  return scene;
}

/// Values with those of dependent nodes from their parent nodes.
inline std::vector<double> followed(const Scene& scene, std::vector<double> values) {
  scene.dependent.fill(values.data());
  return values;
}

/// The bar of swinging_bar() bent and in motion, with a step before; its borders are met.
inline State bar_in_motion(const Scene& scene) {
  State state = initial_state(scene);
  const Array<double>& X = scene.grid.rest;
  std::vector<double> u(size_t(X.size())), v(u.size());
  for (int64_t n = 0; n < X.rows(); ++n) {
    const double bend = scene.pinned(n) ? 0 : std::sin(std::numbers::pi * X(n, 0));
    u[size_t(3 * n + 1)] = 0.01 * bend;
    v[size_t(3 * n + 1)] = 0.6 * bend;
    v[size_t(3 * n + 2)] = 0.2 * bend;
  }
  u = followed(scene, u), v = followed(scene, v);
  state.x_before = state.x, state.v_before = state.v;
  for (size_t k = 0; k < u.size(); ++k) {
    state.x.data()[k] += u[k];
    state.x_before.data()[k] = state.x.data()[k] - scene.dt * v[k];
    state.v.data()[k] = v[k];
    state.v_before.data()[k] = 1.1 * v[k];
  }
  return state;
}

}  // namespace elastogen::test
