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

}  // namespace elastogen::test
