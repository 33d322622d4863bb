// SPDX-License-Identifier: Apache-2.0
#include "core/collider.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

double length(const Vec3& v) {
  return std::hypot(v[0], v[1], v[2]);
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

/// Share of the way from q along m at which |q + t m| falls to `reach` < |q|.
double share_to_sphere(const Vec3& q, const Vec3& m, double reach) {
  const double away = dot(q, m), size = length(q);
  const double c = (size - reach) * (size + reach), root = away * away - dot(m, m) * c;
  return away >= 0 || root < 0 ? 1 : std::min(1.0, c / (std::sqrt(root) - away));
}

/// The same for a box of these half edges that q is outside of.
double share_to_box(const Vec3& q, const Vec3& m, const Vec3& half) {
  double in = -1, out = 1e300;
  for (size_t d = 0; d < 3; ++d) {
    if (m[d] == 0 && std::abs(q[d]) >= half[d]) return 1;
    if (m[d] == 0) continue;
    const double middle = -q[d] / m[d], width = half[d] / std::abs(m[d]);
    in = std::max(in, middle - width);
    out = std::min(out, middle + width);
  }
  return in < 0 || in > out ? 1 : std::min(1.0, in);
}

}  // namespace

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

double free_share(const Collider& c, const Vec3& offset, const Vec3& a, const Vec3& b,
                  double least) {
  constexpr double kLeft = 0.1;
  const double distance = proximity(c, offset, a).distance;
  const double left = std::max(kLeft * distance, std::min(distance, least));
  if (c.shape == Collider::Shape::kPlane) {
    const double approach = distance - proximity(c, offset, b).distance;
    return distance - left < approach ? (distance - left) / approach : 1;
  }
  const Vec3 q = minus(minus(a, c.centre), offset), m = minus(b, a);
  if (c.shape == Collider::Shape::kSphere) return share_to_sphere(q, m, c.radius + left);
  Vec3 half;
  for (size_t d = 0; d < 3; ++d) half[d] = c.half[d] + left;
  return share_to_box(q, m, half);
}

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
  const Vec3 p = minus(minus(point, c.centre), offset);
  if (c.shape == Collider::Shape::kPlane) return {dot(p, c.normal), c.normal};
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
