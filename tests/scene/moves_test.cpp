// SPDX-License-Identifier: Apache-2.0
// Parts that move: what holds them in the network and in finite elements, and the points that go along.
#include "core/error.hpp"
#include "core/held_nodes.hpp"
#include "scene/carried_points.hpp"
#include "scene/fem_scene.hpp"
#include "scene/set_up.hpp"
#include "tests/scene/long_bar.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen {
namespace {

RunDescription run_of(const std::vector<std::string>& pins, const std::vector<std::string>& moves) {
  RunDescription run;
  run.h = 0.05;
  run.solver.device = Device::kCpu;
  for (const std::string& text : pins) run.pins.push_back(parse_pin(text));
  for (const std::string& text : moves) run.moves.push_back(parse_move(text));
  return run;
}

Setup moved(const std::vector<std::string>& pins, const std::vector<std::string>& moves) {
  return set_up(long_bar(), run_of(pins, moves));
}

constexpr const char* kShift = "x>99%: shift 0:0,0,0; 1:0.1,0,0";
constexpr const char* kTurn = "x>99%: turn(0,50%,50%,1,0,0) 0:0; 1:90deg";

TEST(Moves, HoldTheBodyAtBordersThatCutVoxels) {
  const auto setup = moved({"x<1%"}, {kShift});
  ASSERT_EQ(setup.scene.holders.size(), 2u);
  EXPECT_FALSE(setup.scene.holders[0].moves());
  EXPECT_TRUE(setup.scene.holders[1].moves());
  EXPECT_FALSE(setup.scene.dependent.empty());
  int64_t of[2] = {};
  for (int64_t n = 0; n < setup.scene.holder.rows(); ++n) {
    EXPECT_EQ(setup.scene.holder(n) >= 0, setup.scene.pinned(n) != kFreeNode);
    if (setup.scene.holder(n) < 0) continue;
    ++of[setup.scene.holder(n)];
    EXPECT_EQ(setup.scene.holder(n) == 1, setup.scene.grid.rest(n, 0) > 0.5);
  }
  EXPECT_GT(of[0], 0);
  EXPECT_GT(of[1], 0);
}

TEST(Moves, CarryThePointsBehindTheirBordersExactly) {
  const auto setup = moved({"x<1%"}, {kTurn});
  const CarriedPoints points = carried_points(setup);
  ASSERT_EQ(points.moved.size(), 4u);  // the corners at the right; those at the left rest
  Array<double> u(points.count, 3), F(points.count, 9);
  place_moved(points, setup, 1, u, &F);
  for (const HeldPoint& held : points.moved) {
    // a quarter turn about the middle of the bar: (y, z) to (-z, y)
    const double y = setup.body.carried(held.point, 1) - 0.1,
                 z = setup.body.carried(held.point, 2) - 0.1;
    EXPECT_NEAR(u(held.point, 0), 0, 1e-15);
    EXPECT_NEAR(u(held.point, 1), -z - y, 1e-15);
    EXPECT_NEAR(u(held.point, 2), y - z, 1e-15);
    EXPECT_NEAR(F(held.point, 7), 1, 1e-15);  // dz/dy
  }
}

TEST(Moves, ThatContradictOthersAreRefusedByName) {
  const auto message = [](const std::vector<std::string>& pins,
                          const std::vector<std::string>& moves) -> std::string {
    try {
      moved(pins, moves);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message({"x>99%"}, {kShift}).find("contradict each other"), std::string::npos);
  EXPECT_NE(message({"x>90%"}, {kShift, "x<1%: shift 0:0,0,0"}).find("--pin 'x>90%'"),
            std::string::npos);
  EXPECT_NE(message({}, {kShift, kTurn}).find("contradict each other"), std::string::npos);
  EXPECT_EQ(message({"x<1%"}, {kShift}), "");
}

TEST(Moves, OfFiniteElementsFollowTheSameHolders) {
  RunDescription run = run_of({"x<1%"}, {kTurn});
  run.fem = FemOptions{};
  const auto setup = set_up(long_bar(), run);
  ASSERT_FALSE(setup.scene.dependent.empty());
  const fem::FemScene scene = fem_scene(setup, run);
  ASSERT_TRUE(bool(scene.dependent_motion));
  HeldNodes held(setup.scene);
  held.set_time(0.4);
  Array<double> offset(setup.scene.dependent.count(), 3);
  scene.dependent_motion(0.4, offset);
  double largest = 0;
  for (int64_t i = 0; i < offset.rows(); ++i)
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(offset(i, d), held.offset(i)[size_t(d)]);
      largest = std::max(largest, std::abs(offset(i, d)));
    }
  EXPECT_GT(largest, 0);
}

TEST(Moves, OfTetrahedraMoveNodes) {
  RunDescription run = run_of({}, {"x>100%: shift 0:0,0,0; 1:0.1,0,0"});
  run.fem = FemOptions{.element = fem::Element::kTet4, .named = true};
  const auto setup = set_up(long_bar(), run);
  const fem::FemScene scene = fem_scene(setup, run);
  ASSERT_TRUE(bool(scene.motion));
  Array<double> u(scene.mesh.rest.rows(), 3);
  scene.motion(0.5, u);
  int64_t moving = 0;
  for (int64_t n = 0; n < u.rows(); ++n) {
    moving += scene.fixed(n, 0);
    EXPECT_DOUBLE_EQ(u(n, 0), scene.fixed(n, 0) ? 0.05 : 0);
  }
  EXPECT_GT(moving, 0);
}

}  // namespace
}  // namespace elastogen
