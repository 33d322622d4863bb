// SPDX-License-Identifier: Apache-2.0
// A bar that is folded within a voxel, where frames of voxels and nodes lie far apart.

#pragma once

#include "core/collider.hpp"
#include "network/potential/incremental_potential.hpp"
#include "tests/network/scenes.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::test {

inline constexpr double kFoldEdge = 0.05;  // of voxels [m]

/// A bar that is pinned at one end, and may lie on a floor.
inline Scene bar_to_fold(bool on_floor) {
  Scene scene = scene_on(make_box(16, 4, 4, kFoldEdge), solid(1e5, 0.4, Law::kNeoHookean));
  pin_below(scene, 0, scene.grid.rest(0, 0) + 0.5 * kFoldEdge);
  scene.materials[0].loss_factor = 0.1;
  scene.dt = 1.0 / 60;
  if (on_floor) {
    const double layer = kFoldEdge / 4;
    scene.surface = face_points(scene.grid);
    scene.colliders = {half_space({0, 1, 0}, scene.grid.rest(0, 1) + 0.3 * layer, 0.5)};
  }
  finish_scene(scene);
  return scene;
}

/// Its second half turned up about a line in its upper face, within a voxel.
inline std::vector<double> folded_up(const Scene& scene, double angle) {
  const Array<double>& X = scene.grid.rest;
  double lowest[3], highest[3];
  for (int d = 0; d < 3; ++d) {
    lowest[d] = highest[d] = X(0, d);
    for (int64_t n = 0; n < X.rows(); ++n)
      lowest[d] = std::min(lowest[d], X(n, d)), highest[d] = std::max(highest[d], X(n, d));
  }
  const double middle = (lowest[0] + highest[0]) / 2, top = highest[1];
  std::vector<double> u(size_t(X.size()));
  for (int64_t n = 0; n < X.rows(); ++n) {
    const double share = std::clamp((X(n, 0) - middle) / kFoldEdge + 0.5, 0.0, 1.0),
                 a = angle * share * share * (3 - 2 * share), x = X(n, 0) - middle,
                 y = X(n, 1) - top;
    u[size_t(3 * n)] = std::cos(a) * x - std::sin(a) * y - x;
    u[size_t(3 * n + 1)] = std::sin(a) * x + std::cos(a) * y - y;
  }
  return u;
}

struct Folded {
  explicit Folded(double angle, bool on_floor = false)
      : scene(bar_to_fold(on_floor)), potential(scene), u(folded_up(scene, angle)) {
    potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
    potential.set_nodal_rotations(u.data());
    potential.linearise(u.data(), TangentKind::kProjected);
  }
  int64_t size() const { return int64_t(u.size()); }

  Scene scene;
  IncrementalPotential potential;
  std::vector<double> u;
};

}  // namespace elastogen::test
