// SPDX-License-Identifier: Apache-2.0
#include "scene/impact_speed.hpp"

#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// Largest speed on a path [m/s].
double path_speed(const Collider& collider) {
  double fastest = 0;
  const std::vector<PathKey>& keys = collider.path.keys;
  for (size_t k = 1; k < keys.size(); ++k) {
    const PathKey &from = keys[k - 1], &to = keys[k];
    fastest = std::max(fastest, norm(minus(to.offset, from.offset)) / (to.time - from.time));
  }
  return collider.path.eases ? 1.5 * fastest : fastest;
}

/// Work of gravity per mass on the way from a point to the far side of a collider [m^2/s^2].
double fall(const Collider& collider, const Vec3& offset, const Vec3& from, const Vec3& gravity) {
  if (collider.shape == ColliderForm::Shape::kPlane) {
    const double towards = -dot(gravity, collider.normal);
    return std::max(0.0, towards * proximity(collider, offset, from).distance);
  }
  const double reach =
      collider.shape == ColliderForm::Shape::kSphere ? collider.radius : norm(collider.half);
  const Vec3 way = minus(plus(collider.centre, offset), from);
  return std::max(0.0, dot(gravity, way) + norm(gravity) * reach);
}

}  // namespace

double impact_speed(const Scene& scene, const StartMotion& motion) {
  if (scene.colliders.empty()) return 0;
  // the body and its own motion
  Box box;
  const Array<double>& X = scene.surface.position;
  for (int64_t p = 0; p < X.rows(); ++p) box.add({X(p, 0), X(p, 1), X(p, 2)});
  Vec3 centre = {}, half = {};
  for (size_t d = 0; d < 3; ++d) {
    centre[d] = (box.lower[d] + box.upper[d]) / 2;
    half[d] = (box.upper[d] - box.lower[d]) / 2;
  }
  const Vec3 v = {motion.velocity[0], motion.velocity[1], motion.velocity[2]};
  const Vec3 w = {motion.spin[0], motion.spin[1], motion.spin[2]};
  const double own = norm(v) + norm(w) * norm(half);

  // the colliders, and the way to them
  double square = 0;
  for (const Collider& collider : scene.colliders) {
    double work = fall(collider, {}, centre, scene.gravity);
    for (const PathKey& key : collider.path.keys)
      work = std::max(work, fall(collider, key.offset, centre, scene.gravity));
    const double speed = own + path_speed(collider);
    square = std::max(square, speed * speed + 2 * work);
  }
  return std::sqrt(square);
}

}  // namespace elastogen
