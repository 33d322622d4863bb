// SPDX-License-Identifier: Apache-2.0
// Colliders and bodies for tests of contact.

#pragma once

#include "tests/network/scenes.hpp"

namespace elastogen::test {

inline Collider ball(const Vec3& centre, double radius, double friction = 0.5) {
  Collider c;
  c.name = "ball";
  c.shape = Collider::Shape::kSphere;
  c.centre = centre;
  c.radius = radius;
  c.friction = friction;
  return c;
}

inline Collider block(const Vec3& centre, const Vec3& half, double friction = 0.5) {
  Collider c;
  c.name = "block";
  c.shape = Collider::Shape::kBox;
  c.centre = centre;
  c.half = half;
  c.friction = friction;
  return c;
}

/// A free full box with its lower corner at `corner`, under gravity along -y; finished.
inline Scene box_scene(int nx, int ny, int nz, double h, const Vec3& corner,
                       const Material& material, std::vector<Collider> colliders,
                       double gravity = -9.81) {
  Scene scene = scene_on(make_box(nx, ny, nz, h, corner), material);
  scene.surface = face_points(scene.grid);
  scene.colliders = std::move(colliders);
  scene.gravity = {0, gravity, 0};
  finish_scene(scene);
  return scene;
}

inline constexpr double kEdge = 0.02;  // of voxels [m]

/// Every kind of collider, each touched by a side of a body at the origin; the sphere moves.
inline std::vector<Collider> one_of_each() {
  const double layer = kEdge / 4;
  Collider sphere = ball({0.12, 0.09, -0.3 + 0.4 * layer}, 0.3);
  sphere.path = {{0, {}}, {1, {0.06, 0.03, 0}}};
  return {half_space({0, 1, 0}, 0.3 * layer, 0.5), sphere,
          block({-0.1 + 0.5 * layer, 0.09, 0.1}, {0.1, 1, 1})};
}

/// A block that touches all of them, pinned on the far side.
inline Scene box_in_touch() {
  Scene scene = box_scene(12, 9, 10, kEdge, {0, 0, 0}, solid(1e5, 0.3), one_of_each());
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    scene.pinned(n) = scene.grid.node_coord(n, 0) == 12;
  return scene;
}

}  // namespace elastogen::test
