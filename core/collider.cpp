// SPDX-License-Identifier: Apache-2.0
#include "core/collider.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

double length(const Vec3& v) {
  return std::hypot(v[0], v[1], v[2]);
}

bool finite(const Vec3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

/// p from the centre of a box: outside to the nearest point, inside to the nearest face.
Proximity box_proximity(const Vec3& half, const Vec3& p) {
  Vec3 beyond;
  double largest = -1e300;
  size_t axis = 0;
  for (size_t d = 0; d < 3; ++d) {
    beyond[d] = std::abs(p[d]) - half[d];
    if (beyond[d] > largest) largest = beyond[d], axis = d;
  }
  Proximity result;
  if (largest <= 0) {
    result.distance = largest;
    result.normal[axis] = std::copysign(1, p[axis]);
    return result;
  }
  for (size_t d = 0; d < 3; ++d) result.normal[d] = std::copysign(std::max(beyond[d], 0.0), p[d]);
  result.distance = length(result.normal);
  for (double& n : result.normal) n /= result.distance;
  return result;
}

}  // namespace

Vec3 offset_at(const Collider& c, double time) {
  if (c.path.empty()) return {};
  if (time <= c.path.front().time) return c.path.front().offset;
  for (size_t k = 1; k < c.path.size(); ++k) {
    const PathKey &a = c.path[k - 1], &b = c.path[k];
    if (time > b.time) continue;
    const double share = (time - a.time) / (b.time - a.time);
    Vec3 offset;
    for (size_t d = 0; d < 3; ++d) offset[d] = a.offset[d] + share * (b.offset[d] - a.offset[d]);
    return offset;
  }
  return c.path.back().offset;
}

Proximity proximity(const Collider& c, const Vec3& offset, const Vec3& point) {
  Vec3 p;
  for (size_t d = 0; d < 3; ++d) p[d] = point[d] - c.centre[d] - offset[d];
  if (c.shape == Collider::Shape::kPlane)
    return {p[0] * c.normal[0] + p[1] * c.normal[1] + p[2] * c.normal[2], c.normal};
  if (c.shape == Collider::Shape::kBox) return box_proximity(c.half, p);
  const double r = length(p);
  // the centre of a sphere is as far from everywhere: up, by choice
  if (r == 0) return {-c.radius, {0, 1, 0}};
  return {r - c.radius, {p[0] / r, p[1] / r, p[2] / r}};
}

void check_collider(const Collider& c) {
  ELASTOGEN_CHECK(finite(c.centre), "collider '", c.name, "': its place must be finite");
  ELASTOGEN_CHECK(c.friction >= 0 && std::isfinite(c.friction), "collider '", c.name,
                  "': friction must not be negative, got ", c.friction);
  if (c.shape == Collider::Shape::kPlane)
    ELASTOGEN_CHECK(std::abs(length(c.normal) - 1) < 1e-9, "collider '", c.name,
                    "': its normal must be a unit vector");
  if (c.shape == Collider::Shape::kSphere)
    ELASTOGEN_CHECK(c.radius > 0 && std::isfinite(c.radius), "collider '", c.name,
                    "': its radius must be positive, got ", c.radius);
  if (c.shape == Collider::Shape::kBox)
    for (const double half : c.half)
      ELASTOGEN_CHECK(half > 0 && std::isfinite(half), "collider '", c.name,
                      "': its edges must be positive, got ", 2 * half);
  for (size_t k = 0; k < c.path.size(); ++k) {
    ELASTOGEN_CHECK(std::isfinite(c.path[k].time) && finite(c.path[k].offset), "collider '", c.name,
                    "': key ", k, " of its path is not finite");
    ELASTOGEN_CHECK(k == 0 || c.path[k].time > c.path[k - 1].time, "collider '", c.name,
                    "': the times of its path must ascend, key ", k, " does not");
  }
}

}  // namespace elastogen
