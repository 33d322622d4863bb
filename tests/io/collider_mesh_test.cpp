// SPDX-License-Identifier: Apache-2.0
#include "io/collider_mesh.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <utility>

namespace elastogen {
namespace {

const Box kSeen = {{-1, 0, 2}, {1, 1, 3}};

Vec3 row(const Array<double>& x, int64_t r) {
  return {x(r, 0), x(r, 1), x(r, 2)};
}

/// Area, enclosed volume, and how well the triangles face along the normals of their vertices.
struct Measure {
  double area = 0, volume = 0, worst_facing = 1;
};

Measure measured(const ColliderMesh& mesh) {
  Measure m;
  for (int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    Vec3 x[3];
    for (int c = 0; c < 3; ++c) x[c] = row(mesh.position, mesh.triangles(t, c));
    const Vec3 twice = cross(minus(x[1], x[0]), minus(x[2], x[0]));
    m.area += norm(twice) / 2;
    m.volume += dot(x[0], twice) / 6;
    for (int c = 0; c < 3; ++c)
      m.worst_facing = std::min(m.worst_facing,
                                dot(twice, row(mesh.normal, mesh.triangles(t, c))) / norm(twice));
  }
  return m;
}

/// Every edge has a triangle on both sides; vertices of one place count as one.
void expect_closed(const ColliderMesh& mesh) {
  std::map<Vec3, int> place;
  std::map<std::pair<int, int>, int> used;
  const auto at = [&](int64_t t, int c) {
    return place.try_emplace(row(mesh.position, mesh.triangles(t, c % 3)), int(place.size()))
        .first->second;
  };
  for (int64_t t = 0; t < mesh.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) ++used[{at(t, c), at(t, c + 1)}];
  for (const auto& [edge, count] : used) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(used.contains({edge.second, edge.first}));
  }
}

TEST(ColliderMesh, OfASphereClosesNearlyItsVolume) {
  Collider sphere;
  sphere.shape = Collider::Shape::kSphere;
  sphere.centre = {3, -2, 1};
  sphere.radius = 0.5;
  const ColliderMesh mesh = collider_mesh(sphere, kSeen);
  expect_closed(mesh);
  for (int64_t v = 0; v < mesh.position.rows(); ++v) {
    EXPECT_NEAR(norm(minus(row(mesh.position, v), sphere.centre)), 0.5, 1e-15);
    EXPECT_NEAR(norm(row(mesh.normal, v)), 1, 1e-15);
  }
  // chords of 2 pi/48 lie within 1 - cos(pi/48) = 0.2 % of the radius
  const Measure m = measured(mesh);
  EXPECT_NEAR(m.volume, 4.0 / 3 * std::numbers::pi * 0.125, 0.01 * m.volume);
  EXPECT_GT(m.worst_facing, 0.99);
}

TEST(ColliderMesh, OfABoxHasItsAreaAndVolume) {
  Collider box;
  box.shape = Collider::Shape::kBox;
  box.centre = {1, 2, 3};
  box.half = {0.5, 1, 1.5};
  const ColliderMesh mesh = collider_mesh(box, kSeen);
  expect_closed(mesh);
  const Measure m = measured(mesh);
  EXPECT_NEAR(m.volume, 1 * 2 * 3, 1e-12);
  EXPECT_NEAR(m.area, 2 * (2 + 6 + 3), 1e-12);
  EXPECT_NEAR(m.worst_facing, 1, 1e-15);
}

TEST(ColliderMesh, OfAPlaneIsASquareBelowWhatIsSeen) {
  for (const Vec3& direction : {Vec3{0, 1, 0}, {0, 0, -1}, {1, 2, -2}}) {
    Collider plane;
    plane.normal = scaled(direction, 1 / norm(direction));
    plane.centre = {7, -1, 5};
    const ColliderMesh mesh = collider_mesh(plane, kSeen);
    ASSERT_EQ(mesh.position.rows(), 4);
    const Measure m = measured(mesh);
    EXPECT_NEAR(m.worst_facing, 1, 1e-12);
    // 1.5 times the extent 2 of x
    if (direction[0] == 0) {
      EXPECT_NEAR(m.area, 3 * 3, 1e-12);
    }
    Vec3 middle = {};
    for (int v = 0; v < 4; ++v) {
      EXPECT_NEAR(dot(minus(row(mesh.position, v), plane.centre), plane.normal), 0, 1e-12);
      middle = plus(middle, scaled(row(mesh.position, v), 0.25));
    }
    EXPECT_NEAR(norm(cross(minus(middle, {0, 0.5, 2.5}), plane.normal)), 0, 1e-12);
    // every corner of the box lies above the square
    const double half = norm(minus(row(mesh.position, 0), row(mesh.position, 1))) / 2;
    for (int k = 0; k < 8; ++k) {
      const Vec3 corner = {k & 1 ? 1. : -1., k & 2 ? 1. : 0., k & 4 ? 3. : 2.};
      for (const int to : {1, 3}) {
        const Vec3 edge = minus(row(mesh.position, to), row(mesh.position, 0));
        EXPECT_LT(std::abs(dot(minus(corner, middle), edge)) / norm(edge), half);
      }
    }
  }
}

TEST(ColliderMesh, RejectsAnEmptyBoxAndABadCollider) {
  EXPECT_THROW(collider_mesh({}, Box{}), Error);
  Collider bent;
  bent.normal = {0, 2, 0};
  EXPECT_THROW(collider_mesh(bent, kSeen), Error);
}

}  // namespace
}  // namespace elastogen
