// SPDX-License-Identifier: Apache-2.0
#include "scene/impact_speed.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen::test {
namespace {

/// Two points 0.2 m apart, whose centre is 1 m above the origin, under gravity along -y.
Scene body_above() {
  Scene scene;
  scene.gravity = {0, -9.81, 0};
  scene.surface.position = Array<double>(2, 3);
  scene.surface.position(0, 1) = 0.9;
  scene.surface.position(1, 1) = 1.1;
  return scene;
}

TEST(ImpactSpeed, IsThatOfFreeFallOntoALevelFloor) {
  Scene scene = body_above();
  EXPECT_EQ(impact_speed(scene, {}), 0);  // nothing to meet
  scene.colliders = {half_space({0, 1, 0}, 0, 0.5)};
  EXPECT_NEAR(impact_speed(scene, {}), std::sqrt(2 * 9.81), 1e-12);
  // thrown up or down makes no difference
  for (const double v : {-3.0, 3.0})
    EXPECT_NEAR(impact_speed(scene, {.velocity = {0, v, 0}}), std::sqrt(9 + 2 * 9.81), 1e-12);
}

TEST(ImpactSpeed, OfASlopeCountsGravityAlongItsNormal) {
  Scene scene = body_above();
  const double angle = 0.4, normal_distance = std::cos(angle);
  scene.colliders = {half_space({std::sin(angle), std::cos(angle), 0}, 0, 0.5)};
  EXPECT_NEAR(impact_speed(scene, {}), std::sqrt(2 * 9.81 * std::cos(angle) * normal_distance),
              1e-12);
  scene.colliders = {half_space({0, -1, 0}, -5, 0.5)};  // a ceiling
  EXPECT_EQ(impact_speed(scene, {}), 0);
}

TEST(ImpactSpeed, HasSpinAndTheSpeedOfPaths) {
  Scene scene = body_above();
  scene.gravity = {};
  Collider ball = {};
  ball.shape = ColliderForm::Shape::kSphere;
  ball.centre = {0, -1, 0};
  ball.radius = 0.5;
  ball.path = {{0, {}}, {0.5, {0, 1, 0}}, {1.5, {0, 2, 0}}};
  scene.colliders = {ball};
  EXPECT_NEAR(impact_speed(scene, {.spin = {0, 0, 10}}), 2 + 10 * 0.1, 1e-12);
  // down to its far side
  scene.gravity = {0, -9.81, 0};
  scene.colliders[0].path = {};
  EXPECT_NEAR(impact_speed(scene, {}), std::sqrt(2 * 9.81 * 2.5), 1e-12);
}

}  // namespace
}  // namespace elastogen::test
