// SPDX-License-Identifier: Apache-2.0
// Half space, sphere and box: distance and normal at a point, and how far a point may move towards
// them. Shared by host and device.

#pragma once

#include "core/vec3.hpp"

#include <algorithm>

namespace elastogen {

/// Distance of a point to a collider's surface, negative inside, and the unit normal that points
/// out of the collider.
struct Proximity {
  double distance = 0;  ///< [m]
  Vec3 normal = {};
};

/// Form and place of a collider before it moves.
struct ColliderForm {
  enum class Shape { kPlane, kSphere, kBox };
  Shape shape = Shape::kPlane;
  Vec3 centre = {};         ///< plane: a point of it; sphere, box: the centre [m]
  Vec3 normal = {0, 1, 0};  ///< plane: unit vector to the free side
  double radius = 0;        ///< sphere [m]
  Vec3 half = {};           ///< box: half its edges, parallel to the axes [m]
};

namespace detail {

/// p from the centre of a box: outside to the nearest point, inside to the nearest face.
ELASTOGEN_HD inline Proximity box_proximity(const Vec3& half, const Vec3& p) {
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
    result.normal[axis] = std::copysign(1.0, p[axis]);
    return result;
  }
  for (size_t d = 0; d < 3; ++d) result.normal[d] = std::copysign(std::max(beyond[d], 0.0), p[d]);
  result.distance = safe_norm(result.normal);
  for (size_t d = 0; d < 3; ++d) result.normal[d] /= result.distance;
  return result;
}

/// Share t of the motion m from q at which |q + t m| falls to `reach` < |q|; 1 if it does not.
ELASTOGEN_HD inline double share_to_sphere(const Vec3& q, const Vec3& m, double reach) {
  const double away = dot(q, m), size = safe_norm(q);
  const double c = (size - reach) * (size + reach), root = away * away - dot(m, m) * c;
  return away >= 0 || root < 0 ? 1 : std::min(1.0, c / (std::sqrt(root) - away));
}

/// Share of the motion m at which q enters a box with these half edges, 1 if it does not; q is
/// outside.
ELASTOGEN_HD inline double share_to_box(const Vec3& q, const Vec3& m, const Vec3& half) {
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

}  // namespace detail

/// Distance and normal of a point, for a collider moved by `offset`.
ELASTOGEN_HD inline Proximity proximity(const ColliderForm& c, const Vec3& offset,
                                        const Vec3& point) {
  const Vec3 p = minus(minus(point, c.centre), offset);
  if (c.shape == ColliderForm::Shape::kPlane) return {dot(p, c.normal), c.normal};
  if (c.shape == ColliderForm::Shape::kBox) return detail::box_proximity(c.half, p);
  const double r = safe_norm(p);
  // the centre is equally far from all of the surface: up, by choice
  if (r == 0) return {-c.radius, {0, 1, 0}};
  return {r - c.radius, {p[0] / r, p[1] / r, p[2] / r}};
}

/// Largest share, at most 1, of the straight path from a to b on which a point outside a collider
/// keeps a tenth of its distance at a, and no less than `least` [m] if it has that at a. It is a
/// little smaller where the path ends at the edge of a box.
ELASTOGEN_HD inline double free_share(const ColliderForm& c, const Vec3& offset, const Vec3& a,
                                      const Vec3& b, double least) {
  constexpr double kLeft = 0.1;
  const double distance = proximity(c, offset, a).distance;
  const double left = std::max(kLeft * distance, std::min(distance, least));
  if (c.shape == ColliderForm::Shape::kPlane) {
    const double approach = distance - proximity(c, offset, b).distance;
    return distance - left < approach ? (distance - left) / approach : 1;
  }
  const Vec3 q = minus(minus(a, c.centre), offset), m = minus(b, a);
  if (c.shape == ColliderForm::Shape::kSphere)
    return detail::share_to_sphere(q, m, c.radius + left);
  Vec3 half;
  for (size_t d = 0; d < 3; ++d) half[d] = c.half[d] + left;
  return detail::share_to_box(q, m, half);
}

}  // namespace elastogen
