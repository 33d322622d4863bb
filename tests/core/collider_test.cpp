// SPDX-License-Identifier: Apache-2.0
#include "core/collider.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace elastogen {
namespace {

using Shape = Collider::Shape;

Collider ball(const Vec3& centre, double radius) {
  Collider c;
  c.name = "ball";
  c.shape = Shape::kSphere;
  c.centre = centre;
  c.radius = radius;
  return c;
}

Collider block(const Vec3& centre, const Vec3& half) {
  Collider c;
  c.name = "block";
  c.shape = Shape::kBox;
  c.centre = centre;
  c.half = half;
  return c;
}

TEST(Collider, DistancesOfKnownPoints) {
  const Proximity plane = proximity(half_space({0.6, 0.8, 0}, 2, 0), {1, 0, 0}, {0, 0, 5});
  EXPECT_NEAR(plane.distance, -2.6, 1e-15);
  EXPECT_EQ(plane.normal, (Vec3{0.6, 0.8, 0}));
  const Proximity sphere = proximity(ball({1, 0, 0}, 2), {0, 1, 0}, {1, 4, 4});
  EXPECT_NEAR(sphere.distance, 3, 1e-15);
  EXPECT_NEAR(sphere.normal[1], 0.6, 1e-15);
  const Collider box = block({0, 0, 0}, {1, 2, 3});
  EXPECT_NEAR(proximity(box, {}, {4, 6, 0}).distance, 5, 1e-15);       // from an edge
  EXPECT_NEAR(proximity(box, {}, {4, 6, -15}).distance, 13, 1e-15);    // from a corner
  EXPECT_NEAR(proximity(box, {}, {0.5, 1, 1}).distance, -0.5, 1e-15);  // from inside
  EXPECT_EQ(proximity(box, {}, {-0.5, 1, 1}).normal, (Vec3{-1, 0, 0}));
}

TEST(Collider, TheCoreLiesALayerBelowTheSurface) {
  const double layer = 0.25;
  const Vec3 outside = {0, 5, 0};
  for (const Collider& c : {half_space({0, 1, 0}, 1, 0), ball({0, 0, 0}, 1), block({}, {1, 1, 1})})
    EXPECT_NEAR(proximity(core_of(c, layer), {}, outside).distance, 4 + layer, 1e-15);
  // a collider thinner than two layers keeps its middle
  EXPECT_EQ(core_of(block({}, {1, 0.1, 1}), layer).half, (Vec3{0.75, 0, 0.75}));
  EXPECT_EQ(core_of(ball({}, 0.1), layer).radius, 0);
}

/// Smallest distance on the segment from a to its share t towards b, by sampling.
double least_distance(const Collider& c, const Vec3& a, const Vec3& b, double t) {
  double least = 1e300;
  for (int k = 0; k <= 4000; ++k) {
    Vec3 p;
    for (size_t d = 0; d < 3; ++d) p[d] = a[d] + t * k / 4000 * (b[d] - a[d]);
    least = std::min(least, proximity(c, {}, p).distance);
  }
  return least;
}

TEST(Collider, AFreeShareKeepsATenthOfTheDistanceAllAlong) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-3, 3);
  int cut = 0;
  for (int k = 0; k < 600; ++k) {
    const Vec3 a = {uniform(random), uniform(random), uniform(random)};
    const Vec3 b = {uniform(random), uniform(random), uniform(random)};
    for (const Collider& c :
         {half_space({0, 0.6, 0.8}, 0, 0), ball({0.1, 0, 0}, 1), block({}, {1, 0.01, 1.5})}) {
      const double distance = proximity(c, {}, a).distance;
      if (distance <= 0) continue;
      const double share = free_share(c, {}, a, b, 0);
      ASSERT_GT(share, 0);
      ASSERT_LE(share, 1);
      cut += share < 1;
      const double least = least_distance(c, a, b, share);
      EXPECT_GT(least, 0.1 * distance - 1e-12);
      // a share is cut no more than needed: to the tenth, within sqrt 3 of it at a box's corner
      if (share < 1) {
        EXPECT_LT(least, 0.1 * distance * std::sqrt(3) + 1e-9);
      }
    }
  }
  EXPECT_GT(cut, 300);
}

TEST(Collider, APathIsStraightBetweenKeysAndStandsBeyondThem) {
  Collider c = ball({}, 1);
  EXPECT_EQ(offset_at(c, 5), (Vec3{0, 0, 0}));
  c.path = {{1, {0, 1, 0}}, {3, {4, 1, 0}}, {4, {4, 1, -2}}};
  EXPECT_EQ(offset_at(c, 0), (Vec3{0, 1, 0}));
  EXPECT_EQ(offset_at(c, 1.5), (Vec3{1, 1, 0}));
  EXPECT_EQ(offset_at(c, 3.5), (Vec3{4, 1, -1}));
  EXPECT_EQ(offset_at(c, 9), (Vec3{4, 1, -2}));
}

TEST(Collider, WhatCannotBeIsRefusedByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](Collider c, const char* word) {
    c.name = "press";
    try {
      check_collider(c);
    } catch (const Error& error) {
      const std::string text = error.what();
      return text.find("press") != text.npos && text.find(word) != text.npos;
    }
    return false;
  };
  EXPECT_TRUE(refused(half_space({0, 2, 0}, 0, 0), "unit vector"));
  EXPECT_TRUE(refused(half_space({0, 1, 0}, nan, 0), "place"));
  EXPECT_TRUE(refused(half_space({0, 1, 0}, 0, -1), "friction"));
  EXPECT_TRUE(refused(ball({}, 0), "radius"));
  EXPECT_TRUE(refused(block({}, {1, 0, 1}), "edges"));
  Collider c = ball({}, 1);
  c.path = {{1, {}}, {1, {}}};
  EXPECT_TRUE(refused(c, "ascend"));
  c.path = {{1, {nan, 0, 0}}};
  EXPECT_TRUE(refused(c, "key 0"));
}

}  // namespace
}  // namespace elastogen
