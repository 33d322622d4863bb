// SPDX-License-Identifier: Apache-2.0
#include "io/collider_mesh.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

constexpr int kMeridians = 48, kZones = 24;
constexpr double kMargin = 1.5;  // edge of a plane's square over the extent of `seen`

ColliderMesh empty_mesh(int64_t vertices, int64_t triangles) {
  return {Array<double>(vertices, 3), Array<double>(vertices, 3), Array<int32_t>(triangles, 3)};
}

void set_vertex(ColliderMesh& mesh, int64_t v, const Vec3& position, const Vec3& normal) {
  std::copy(position.begin(), position.end(), mesh.position.row(v));
  std::copy(normal.begin(), normal.end(), mesh.normal.row(v));
}

/// Two triangles of the corners v, v + 1, v + 2, v + 3, counter-clockwise.
void set_square(ColliderMesh& mesh, int64_t t, int64_t v) {
  const int corner[6] = {0, 1, 2, 0, 2, 3};
  for (int k = 0; k < 6; ++k) mesh.triangles(t + k / 3, k % 3) = int32_t(v + corner[k]);
}

/// Unit vectors a, b along a plane, a x b its normal; parallel to axes where the plane is.
struct Tangents {
  explicit Tangents(const Vec3& normal) {
    size_t least = 0;
    for (size_t d = 1; d < 3; ++d)
      if (std::abs(normal[d]) < std::abs(normal[least])) least = d;
    Vec3 axis = {};
    axis[least] = 1;
    b = cross(normal, axis);
    b = scaled(b, 1 / norm(b));
    a = cross(b, normal);
  }
  Vec3 a, b;
};

double extent_along(const Box& box, const Vec3& direction) {
  double extent = 0;
  for (int d = 0; d < 3; ++d) extent += std::abs(direction[size_t(d)]) * box.extent(d);
  return extent;
}

ColliderMesh plane_mesh(const Collider& plane, const Box& seen) {
  const Tangents along(plane.normal);
  const double half =
      kMargin / 2 * std::max(extent_along(seen, along.a), extent_along(seen, along.b));
  Vec3 middle = scaled(plus(seen.lower, seen.upper), 0.5);
  middle = minus(middle, scaled(plane.normal, dot(minus(middle, plane.centre), plane.normal)));
  ColliderMesh mesh = empty_mesh(4, 2);
  for (int k = 0; k < 4; ++k) {
    const double a = k == 0 || k == 3 ? -half : half, b = k < 2 ? -half : half;
    set_vertex(mesh, k, plus(middle, plus(scaled(along.a, a), scaled(along.b, b))), plane.normal);
  }
  set_square(mesh, 0, 0);
  return mesh;
}

ColliderMesh sphere_mesh(const Collider& sphere) {
  const int rings = kZones - 1;  // of vertices between the poles
  ColliderMesh mesh = empty_mesh(rings * kMeridians + 2, 2 * rings * kMeridians);
  // vertices: the poles, and rings between them
  const auto set = [&](int64_t v, const Vec3& n) {
    set_vertex(mesh, v, plus(sphere.centre, scaled(n, sphere.radius)), n);
  };
  const int64_t south = rings * kMeridians, north = south + 1;
  set(south, {0, -1, 0});
  set(north, {0, 1, 0});
  for (int r = 0; r < rings; ++r)
    for (int m = 0; m < kMeridians; ++m) {
      const double across = std::numbers::pi * (r + 1) / kZones;  // from the south pole
      const double about = 2 * std::numbers::pi * m / kMeridians;
      set(r * kMeridians + m, {std::sin(across) * std::sin(about), -std::cos(across),
                               std::sin(across) * std::cos(about)});
    }
  // triangles: caps at both poles, two for each quadrilateral between rings
  int64_t t = 0;
  const auto add = [&](int64_t a, int64_t b, int64_t c) {
    for (const int64_t v : {a, b, c}) mesh.triangles.data()[t++] = int32_t(v);
  };
  for (int m = 0; m < kMeridians; ++m) {
    const int next = (m + 1) % kMeridians;
    add(south, next, m);
    for (int64_t low = 0; low + kMeridians < south; low += kMeridians) {
      add(low + m, low + next, low + kMeridians + next);
      add(low + m, low + kMeridians + next, low + kMeridians + m);
    }
    add(north, south - kMeridians + m, south - kMeridians + next);
  }
  return mesh;
}

ColliderMesh box_mesh(const Collider& box) {
  ColliderMesh mesh = empty_mesh(24, 12);
  for (int face = 0; face < 6; ++face) {
    const auto d = size_t(face / 2), e = (d + 1) % 3, f = (d + 2) % 3;
    Vec3 normal = {};
    normal[d] = face % 2 ? 1 : -1;
    for (int k = 0; k < 4; ++k) {
      Vec3 corner;
      corner[d] = normal[d];
      corner[e] = (k == 1 || k == 2) ? normal[d] : -normal[d];
      corner[f] = k < 2 ? -1 : 1;
      for (size_t i = 0; i < 3; ++i) corner[i] = box.centre[i] + corner[i] * box.half[i];
      set_vertex(mesh, 4 * face + k, corner, normal);
    }
    set_square(mesh, 2 * face, 4 * face);
  }
  return mesh;
}

}  // namespace

ColliderMesh collider_mesh(const Collider& collider, const Box& seen) {
  check_collider(collider);
  ELASTOGEN_CHECK(finite(seen.lower) && finite(seen.upper) && seen.lower[0] <= seen.upper[0],
                  "the box about a collider must not be empty");
  if (collider.shape == Collider::Shape::kPlane) return plane_mesh(collider, seen);
  return collider.shape == Collider::Shape::kSphere ? sphere_mesh(collider) : box_mesh(collider);
}

}  // namespace elastogen
