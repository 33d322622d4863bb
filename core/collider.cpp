// SPDX-License-Identifier: Apache-2.0
#include "core/collider.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

Collider half_space(const Vec3& normal, double offset, double friction) {
  Collider c;
  c.normal = normal;
  for (size_t d = 0; d < 3; ++d) c.centre[d] = offset * normal[d];
  c.friction = friction;
  return c;
}

Collider core_of(const Collider& collider, double layer) {
  Collider core = collider;
  if (core.shape == Collider::Shape::kPlane)
    for (size_t d = 0; d < 3; ++d) core.centre[d] -= layer * core.normal[d];
  core.radius = std::max(core.radius - layer, 0.0);
  for (double& half : core.half) half = std::max(half - layer, 0.0);
  return core;
}

void check_collider(const Collider& c) {
  ELASTOGEN_CHECK(finite(c.centre), "collider '", c.name, "': its place must be finite");
  ELASTOGEN_CHECK(c.friction >= 0, "collider '", c.name, "': friction must not be negative, got ",
                  c.friction);
  if (c.shape == Collider::Shape::kPlane)
    ELASTOGEN_CHECK(std::abs(safe_norm(c.normal) - 1) < 1e-9, "collider '", c.name,
                    "': its normal must be a unit vector");
  if (c.shape == Collider::Shape::kSphere)
    ELASTOGEN_CHECK(c.radius > 0 && std::isfinite(c.radius), "collider '", c.name,
                    "': its radius must be positive, got ", c.radius);
  if (c.shape == Collider::Shape::kBox)
    for (const double half : c.half)
      ELASTOGEN_CHECK(half > 0 && std::isfinite(half), "collider '", c.name,
                      "': its edges must be positive, got ", 2 * half);
  try {
    check_path(c.path);
  } catch (const Error& error) {
    throw Error(concat("collider '", c.name, "': ", error.what()));
  }
}

}  // namespace elastogen
