// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/contact/collider_contact.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

namespace elastogen::fem {
namespace {

constexpr double kLayer = 0.01, kDt = 0.1;

/// Points that are nodes of their own, and one in the middle of the first two.
ContactPoints points_at(const std::vector<Vec3>& places) {
  const auto count = int64_t(places.size());
  ContactPoints points;
  points.nodes = Array<int32_t>(count + 1, 2);
  points.weights = Array<double>(count + 1, 2);
  points.area = Array<double>(count + 1);
  points.position = Array<double>(count + 1, 3);
  points.stiffness = Array<double>(count + 1);
  points.layer = kLayer;
  points.slip_range = 1e-3;
  for (int64_t p = 0; p <= count; ++p) {
    const bool middle = p == count;
    const int64_t a = middle ? 0 : p, b = middle ? 1 : p;
    points.nodes(p, 0) = int32_t(a), points.nodes(p, 1) = int32_t(b);
    points.weights(p, 0) = points.weights(p, 1) = 0.5;
    points.area(p) = 2e-4;
    points.stiffness(p) = 1e5;
    for (int i = 0; i < 3; ++i)
      points.position(p, i) = (places[size_t(a)][size_t(i)] + places[size_t(b)][size_t(i)]) / 2;
  }
  return points;
}

/// A rough plane that moves, a sphere and a box about points in all their layers.
struct ColliderContactTest : testing::Test {
  std::vector<Vec3> places = {
      {0.3, 0.004, 0.1}, {0.35, 0.006, 0.12}, {1.002, 0.5, 0.003}, {-0.5, 0.3, 0.497}, {0, 3, 0}};
  std::vector<Collider> colliders;
  Array<double> start = Array<double>(5, 3);

  ColliderContactTest() {
    Collider plane = half_space({0, 1, 0}, 0.005, 0.6);
    plane.path = {{0, {}}, {kDt, {2e-3, 1e-3, 0}}};
    Collider sphere;
    sphere.name = "ball", sphere.shape = Collider::Shape::kSphere;
    sphere.centre = {1, 0.5, 0.4}, sphere.radius = 0.4, sphere.friction = 0.3;
    Collider box;
    box.name = "box", box.shape = Collider::Shape::kBox;
    box.centre = {-0.5, 0.3, 0.3}, box.half = {0.2, 0.2, 0.2}, box.friction = 0.5;
    colliders = {plane, sphere, box};
  }

  ColliderContact begun() {
    ColliderContact contact(points_at(places), colliders, 5);
    contact.begin_step(start, 0, kDt);
    return contact;
  }

  Array<double> moved(double size) const {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-size, size);
    Array<double> u(5, 3);
    for (int64_t k = 0; k < u.size(); ++k) u.data()[k] = uniform(random);
    return u;
  }
};

/// Sticking (within the slip range) and sliding.
TEST_F(ColliderContactTest, GradientIsTheSlopeOfTheEnergy) {
  for (const double size : {2e-4, 1.5e-3}) {
    ColliderContact contact = begun();
    Array<double> u = moved(size);
    ASSERT_TRUE(std::isfinite(contact.energy(u)));
    Array<double> g(5, 3);
    contact.add_gradient(u, g);
    double largest = 0;
    for (int64_t k = 0; k < g.size(); ++k) largest = std::max(largest, std::abs(g.data()[k]));
    ASSERT_GT(largest, 0.1);
    for (int64_t k = 0; k < u.size(); ++k) {
      constexpr double kStep = 1e-8;
      const double at = u.data()[k];
      u.data()[k] = at + kStep;
      const double above = contact.energy(u);
      u.data()[k] = at - kStep;
      const double below = contact.energy(u);
      u.data()[k] = at;
      EXPECT_NEAR(g.data()[k], (above - below) / (2 * kStep), 2e-6 * largest) << k;
    }
  }
}

/// The plane's Hessian is exact; a sphere and the rounded edge of a box lack a negative part.
TEST_F(ColliderContactTest, HessianOfAPlaneIsTheSlopeOfTheGradient) {
  colliders.resize(1);
  for (const double size : {2e-4, 1.5e-3}) {
    ColliderContact contact = begun();
    Array<double> u = moved(size);
    // the assembled Hessian
    SparseMatrix sparse = pattern_of(contact.stencils(), 5);
    contact.add_hessian(u, TangentKind::kTrue, sparse);
    std::map<std::pair<int64_t, int64_t>, double> hessian;
    double largest = 0;
    for (int64_t row = 0; row < sparse.rows(); ++row)
      for (int32_t k = sparse.start[size_t(row)]; k < sparse.start[size_t(row) + 1]; ++k) {
        hessian[{row, sparse.column[size_t(k)]}] = sparse.value[size_t(k)];
        largest = std::max(largest, std::abs(sparse.value[size_t(k)]));
      }
    // central differences of the gradient, column by column
    for (int64_t column = 0; column < u.size(); ++column) {
      constexpr double kStep = 1e-8;
      Array<double> above(5, 3), below(5, 3);
      const double at = u.data()[column];
      u.data()[column] = at + kStep;
      contact.add_gradient(u, above);
      u.data()[column] = at - kStep;
      contact.add_gradient(u, below);
      u.data()[column] = at;
      for (int64_t row = 0; row < u.size(); ++row) {
        const double slope = (above.data()[row] - below.data()[row]) / (2 * kStep);
        const auto entry = hessian.find({row, column});
        EXPECT_NEAR(entry == hessian.end() ? 0 : entry->second, slope, 1e-5 * largest)
            << row << ' ' << column;
      }
    }
  }
}

/// One point at rest at depth d below the plane: E = A k b(1 - d / D), pushed up, no friction yet.
TEST(ColliderContact, APointInTheLayerHasTheEnergyOfTheBarrier) {
  ColliderContact contact(points_at({{0, -0.003, 0}, {0, 9, 0}}), {half_space({0, 1, 0}, 0, 0.5)},
                          2);
  const Array<double> u(2, 3);
  contact.begin_step(u, 0, kDt);
  const double s = 0.7;
  // friction's potential at zero slip is limit e / 3
  const double force = 2e-4 * 1e5 / kLayer * (-2 * (1 - s) * std::log(s) + (1 - s) * (1 - s) / s);
  EXPECT_NEAR(contact.energy(u),
              -2e-4 * 1e5 * (1 - s) * (1 - s) * std::log(s) + 0.5 * force * 1e-3 / 3, 1e-12);
  Array<double> g(2, 3);
  contact.add_gradient(u, g);
  EXPECT_NEAR(g(0, 1), -force, 1e-9 * force);
  EXPECT_EQ(g(0, 0), 0);
  EXPECT_NEAR(contact.deepest_overlap(u), 0.003, 1e-15);
}

/// Slip beyond the range feels mu N against it, whatever its length.
TEST(ColliderContact, ASlidingPointFeelsCoulombsForce) {
  ColliderContact contact(points_at({{0, -0.003, 0}, {0, 9, 0}}), {half_space({0, 1, 0}, 0, 0.5)},
                          2);
  Array<double> u(2, 3), g(2, 3);
  contact.begin_step(u, 0, kDt);
  contact.add_gradient(u, g);
  const double normal = -g(0, 1);
  u(0, 0) = 0.03, u(0, 2) = 0.04;
  g.fill(0);
  contact.add_gradient(u, g);
  EXPECT_NEAR(std::hypot(g(0, 0), g(0, 2)), 0.5 * normal, 1e-9 * normal);
  EXPECT_NEAR(g(0, 0) / g(0, 2), 0.75, 1e-12);
}

TEST(ColliderContact, WaysEndBeforeACore) {
  ColliderContact contact(points_at({{0, 0.02, 0}, {0, 9, 0}}), {half_space({0, 1, 0}, 0, 0)}, 2);
  const Array<double> u(2, 3);
  Array<double> end(2, 3);
  contact.begin_step(u, 0, kDt);
  end(0, 1) = -1;
  const double share = contact.longest_step(u, end);
  EXPECT_NEAR(0.03 - share, 0.003, 1e-12);  // a tenth of the distance to the core
  end(0, 1) = 1;
  EXPECT_EQ(contact.longest_step(u, end), 1);
}

TEST(ColliderContact, AMovingColliderIsPutWhereItDoesNotCut) {
  Collider floor = half_space({0, 1, 0}, 0, 0);
  floor.path = {{0, {}}, {kDt, {0, 0.2, 0}}};
  ColliderContact contact(points_at({{0, 0, 0}, {0, 9, 0}}), {floor}, 2);
  const Array<double> u(2, 3);
  contact.begin_step(u, 0, kDt);
  ASSERT_EQ(contact.energy(u), std::numeric_limits<double>::infinity());
  EXPECT_STREQ(contact.obstacle(u)->name.c_str(), "floor");
  const double share = contact.clear_share(u, 0);
  EXPECT_GT(share, 0.01);
  contact.stand_at(share);
  EXPECT_TRUE(std::isfinite(contact.energy(u)));
}

TEST(ColliderContact, RefusesNodesThatAreNotThere) {
  EXPECT_THROW(ColliderContact(points_at({{0, 0, 0}, {1, 0, 0}}), {half_space({0, 1, 0}, 0, 0)}, 1),
               Error);
}

}  // namespace
}  // namespace elastogen::fem
