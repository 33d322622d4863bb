// SPDX-License-Identifier: Apache-2.0
#include "scene/boundary.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Boundary, AHoldNamesItsAxes) {
  const Hold hold = parse_hold(" x < 1% : zx");
  EXPECT_EQ(hold.selection.kind, Selection::Kind::kHalfSpace);
  EXPECT_TRUE(hold.selection.lower[0].percent);
  EXPECT_EQ(hold.axes, (std::array<bool, 3>{true, false, true}));
  EXPECT_EQ(parse_hold("all:y").axes, (std::array<bool, 3>{false, true, false}));
}

TEST(Boundary, ATractionIsAForceWithAUnit) {
  EXPECT_EQ(parse_traction("x>99%: 0,-10,0").force, (Vec3{0, -10, 0}));
  EXPECT_EQ(parse_traction("sphere(0,0,0, 1cm): 1, 0, -2 kN").force, (Vec3{1e3, 0, -2e3}));
  EXPECT_EQ(parse_traction("sphere(0,0,0, 1cm): 1, 0, -2 kN").selection.radius, 0.01);
}

TEST(Boundary, OrAPressure) {
  EXPECT_FALSE(parse_traction("x>99%: 0,-10,0").pressure);
  EXPECT_EQ(parse_traction("all: -3").pressure, -3);
  const Traction traction = parse_traction("box(0,0,0, 1,1,1): 1 MPa");
  EXPECT_EQ(traction.pressure, 1e6);
  EXPECT_EQ(traction.force, Vec3{});
  EXPECT_EQ(traction.selection.kind, Selection::Kind::kBox);
}

TEST(Boundary, AMoveIsAShift) {
  const Move move = parse_move("x>99%: shift 0s:0,0,0; 500 ms: 1cm,0,-2");
  EXPECT_FALSE(move.turns);
  ASSERT_EQ(move.path.keys.size(), 2u);
  EXPECT_EQ(move.path.keys[1].time, 0.5);
  EXPECT_EQ(move.path.keys[1].offset, (Vec3{0.01, 0, -2}));
}

TEST(Boundary, OrATurnAboutAPointAndAnAxisOfAnyLength) {
  const Move move = parse_move("all: turn( 50%, 2cm, 0,  0,3,4) 1:0; 2s: 90 deg; 3: -1");
  EXPECT_TRUE(move.turns);
  EXPECT_TRUE(move.turn_centre[0].percent);
  EXPECT_EQ(move.turn_centre[0].value, 0.5);
  EXPECT_EQ(move.turn_centre[1].value, 0.02);
  ASSERT_EQ(move.path.keys.size(), 3u);
  EXPECT_EQ(move.path.keys[0].offset, Vec3{});
  EXPECT_NEAR(move.path.keys[1].offset[1], 0.6 * kPi / 2, 1e-15);
  EXPECT_NEAR(move.path.keys[1].offset[2], 0.8 * kPi / 2, 1e-15);
  EXPECT_EQ(move.path.keys[2].offset, (Vec3{0, -0.6, -0.8}));
}

TEST(Boundary, WhatCannotBeReadIsRefusedWithItsText) {
  struct Row {
    const char *option, *text, *word;
  };
  // `word` stands in the message
  const Row rows[] = {
      {"--hold", "x<1%", "colon"},
      {"--hold", "x<1%:", "no axis"},
      {"--hold", "x<1%: w", "'w' is none"},
      {"--hold", "x<1%: x,y", "none of x, y, z"},
      {"--hold", "x<1%: xyx", "x twice"},
      {"--hold", "q<1%: x", "selection 'q<1%'"},
      {"--traction", "all: 1,2", "three numbers"},
      {"--traction", "all: 1,2,3 Pa", "known are N"},
      {"--traction", "0,0,1", "colon"},
      {"--traction", "all: 1 N", "known are Pa"},
      {"--traction", "all:", "number"},
      {"--traction", "all: inf", "inf"},
      {"--move", "all", "colon"},
      {"--move", "all: 0:1,0,0", "neither shift nor turn"},
      {"--move", "all: shift", "TIME:x,y,z"},
      {"--move", "all: shift 1:0,0", "three lengths"},
      {"--move", "all: shift 1:0,0,0; 1:0,0,0", "ascend"},
      {"--move", "all: shift 1:0,0,1kg", "kg"},
      {"--move", "all: turn 0:1", "bracket"},
      {"--move", "all: turn(0,0,0) 0:1", "needs 6 numbers, got 3"},
      {"--move", "all: turn(0,0,0, 0,0,0) 0:1", "axis has no length"},
      {"--move", "all: turn(0,0,0, 0,0,1)", "TIME:ANGLE"},
      {"--move", "all: turn(0,0,0, 0,0,1) 0:1m", "known are rad, deg"},
      {"--move", "all: turn(0,0,0, 0,0,1) 2:1; 1:1", "ascend"},
  };
  for (const Row& row : rows) {
    const std::string option = row.option;
    try {
      if (option == "--hold") parse_hold(row.text);
      if (option == "--traction") parse_traction(row.text);
      if (option == "--move") parse_move(row.text);
      ADD_FAILURE() << row.text << " is taken";
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
      EXPECT_NE(message.find(row.word), std::string::npos) << message;
      EXPECT_EQ(message.find(option + " '" + row.text + "'"), 0u) << message;
      EXPECT_NE(message.find("SELECTION"), std::string::npos) << message;
    }
  }
}

TEST(Boundary, PathsEaseAndLoopInAnyOrder) {
  const Move move = parse_move("x>99%: shift loop ease 0:0,0,0; 1:1cm,0,0; 2:0,0,0");
  EXPECT_TRUE(move.path.eases && move.path.loops);
  EXPECT_EQ(move.path.keys.size(), 3u);
  EXPECT_TRUE(parse_move("all: turn(0,0,0,0,0,1) loop 0:0; 1:360deg").path.loops);
  EXPECT_THROW(parse_move("x>99%: shift loop 0:0,0,0; 1:1cm,0,0"), Error);
  EXPECT_THROW(parse_move("all: turn(0,0,0,0,0,1) loop 0:0; 1:350deg"), Error);
  EXPECT_THROW(parse_move("x>99%: shift easy 0:0,0,0"), Error);
}

TEST(Boundary, AForceIsConstantOrAPath) {
  const Force constant = parse_force("y>80%: 10,0,-1 N");
  ASSERT_EQ(constant.force.keys.size(), 1u);
  EXPECT_EQ(offset_at(constant.force, 7), (Vec3{10, 0, -1}));
  const Force path = parse_force("y>80%: ease 0:0,0,0; 2s:1,0,0 kN");
  EXPECT_TRUE(path.force.eases);
  EXPECT_EQ(offset_at(path.force, 1), (Vec3{500, 0, 0}));
  EXPECT_THROW(parse_force("y>80%: 10,0"), Error);
  EXPECT_THROW(parse_force("y>80%: 1:0,0,0; 0:1,0,0"), Error);
}

TEST(Boundary, AWindIsConstantOrAPath) {
  EXPECT_EQ(offset_at(parse_wind("36,0,0 km/h"), 3), (Vec3{10, 0, 0}));
  EXPECT_EQ(offset_at(parse_wind("loop 0:1,0,0; 1:3,0,0; 2:1,0,0"), 2.5), (Vec3{2, 0, 0}));
  EXPECT_THROW(parse_wind("north"), Error);
}

}  // namespace
}  // namespace elastogen
