// SPDX-License-Identifier: Apache-2.0
#include "scene/obstacle.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

const PlacedBox kBox = {{{-1, 0, 2}, {1, 4, 3}}};

Collider parsed_collider(std::string_view text) {
  return place_obstacle(parse_obstacle(text), kBox, "collider 1", 0.25);
}

TEST(Obstacle, ReadsEveryShapeWithUnitsAndShares) {
  const Collider plane = parsed_collider("plane(0, 50%, 1cm, 0,3,4)");
  EXPECT_EQ(plane.shape, Collider::Shape::kPlane);
  EXPECT_EQ(plane.centre, (Vec3{0, 2, 0.01}));
  EXPECT_EQ(plane.normal, (Vec3{0, 0.6, 0.8}));
  EXPECT_EQ(plane.friction, 0.25);
  EXPECT_EQ(plane.name, "collider 1");
  EXPECT_TRUE(plane.path.keys.empty());
  const Collider sphere = parsed_collider(" sphere ( 25%,0,100% , 20 cm )");
  EXPECT_EQ(sphere.shape, Collider::Shape::kSphere);
  EXPECT_EQ(sphere.centre, (Vec3{-0.5, 0, 3}));
  EXPECT_EQ(sphere.radius, 0.2);
  const Collider box = parsed_collider("box(-1,-2,-3, 50%,1,5)");
  EXPECT_EQ(box.shape, Collider::Shape::kBox);
  EXPECT_EQ(box.half, (Vec3{0.5, 1.5, 4}));
  EXPECT_THROW(parsed_collider("box(0%,-2,-3, -1,1,5)"), Error);
}

TEST(Obstacle, SticksByAWord) {
  const Collider c = parsed_collider("plane(0,0,0, 0,1,0) friction sticky name mud");
  EXPECT_EQ(c.friction, kSticks);
  EXPECT_EQ(c.name, "mud");
  EXPECT_EQ(place_obstacle(parse_obstacle("plane(0,0,0, 0,1,0)"), kBox, "c", kSticks).friction,
            kSticks);
  EXPECT_THROW(parse_obstacle("plane(0,0,0, 0,1,0) friction glue"), Error);
}

TEST(Obstacle, ReadsFrictionNameAndPathInAnyOrder) {
  const Collider c = parsed_collider(
      "box(-1,-2,-3,1,0,5) path 0:0,0,0; 500ms: 0,-10cm,0 ;1s:1,2,3 name press friction 0.75");
  EXPECT_EQ(c.centre, (Vec3{0, -1, 1}));
  EXPECT_EQ(c.half, (Vec3{1, 1, 4}));
  EXPECT_EQ(c.friction, 0.75);
  EXPECT_EQ(c.name, "press");
  ASSERT_EQ(c.path.keys.size(), 3u);
  EXPECT_EQ(c.path.keys[1].time, 0.5);
  EXPECT_EQ(c.path.keys[1].offset, (Vec3{0, -0.1, 0}));
  EXPECT_EQ(c.path.keys[2].offset, (Vec3{1, 2, 3}));
}

TEST(Obstacle, WhatCannotBeReadIsRefusedWithItsText) {
  const std::pair<const char*, const char*> rows[] = {
      // shapes
      {"cone(0,0,0,1)", "'cone' is none"},
      {"sphere(0,0,0)", "needs 4 numbers, got 3"},
      {"plane(0,0,0,1)", "needs 6 numbers, got 4"},
      {"sphere(0,0,0,1", "bracket"},
      {"plane(0,0,0, 0,0,0)", "normal has no length"},
      {"box(0,0,0, 1,-1,1)", "along y"},
      {"sphere(0,0,0,-1)", "radius"},
      {"sphere(0,0,0,5kg)", "kg"},
      // words behind the shape
      {"sphere(0,0,0,1) slippery", "'slippery' is none of"},
      {"sphere(0,0,0,1) name", "nothing follows 'name'"},
      {"sphere(0,0,0,1) friction much", "much"},
      {"sphere(0,0,0,1) friction -1", "friction"},
      {"sphere(0,0,0,1) path 0,0,0", "TIME:x,y,z"},
      {"sphere(0,0,0,1) path 1:0,0", "three lengths"},
      {"sphere(0,0,0,1) path 1:0,0,0; 1:0,0,0", "ascend"},
      {"sphere(1 0,0,0,1)", "a blank parts two numbers"},
      {"sphere(0,0,0,1) path 0:0,0,0 1:0,0,0", "a blank parts two numbers"},
      {"", "bracket"},
  };
  for (const auto& [text, word] : rows) {
    try {
      parsed_collider(text);
      ADD_FAILURE() << text << " is taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace elastogen
