// SPDX-License-Identifier: Apache-2.0
#include "scene/pins.hpp"

#include "scene/boundary.hpp"
#include "scene/carried_points.hpp"
#include "scene/fem_boundary.hpp"
#include "scene/fem_scene.hpp"
#include "scene/stepper.hpp"
#include "tests/scene/long_bar.hpp"
#include "voxelize/embedding.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace elastogen {
namespace {

RunDescription run_of(const std::vector<std::string>& pins) {
  RunDescription run;
  run.h = 0.05;
  run.solver.device = Device::kCpu;
  for (const std::string& text : pins) run.pins.push_back(parse_pin(text));
  return run;
}

Setup held(const std::vector<std::string>& pins) {
  return set_up(long_bar(), run_of(pins));
}

bool warns(const Setup& setup, const std::string& words) {
  return std::ranges::any_of(
      setup.warnings, [&](const std::string& text) { return text.find(words) != text.npos; });
}

TEST(Pins, ThatTheGridFitsPinNodesAsEver) {
  const auto setup = held({"x<1%", "x>91%"});
  EXPECT_TRUE(setup.scene.dependent.empty());
  EXPECT_TRUE(setup.borders.empty());
  const VoxelGrid& grid = setup.scene.grid;
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    const double x = grid.rest(n, 0);
    EXPECT_EQ(setup.scene.pinned(n), x < 0.011 || x > 0.909);
  }
}

TEST(Pins, HoldBothEndsWhateverTheirOrder) {
  const auto a = held({"x<1%", "x>99%"}), b = held({"x>99%", "x<1%"});
  EXPECT_FALSE(a.scene.dependent.empty());
  EXPECT_EQ(a.scene.grid.rest, b.scene.grid.rest);
  EXPECT_EQ(a.scene.grid.fill, b.scene.grid.fill);
  EXPECT_EQ(a.scene.pinned, b.scene.pinned);
  EXPECT_EQ(a.scene.dependent.count(), b.scene.dependent.count());
  EXPECT_TRUE(std::ranges::none_of(
      a.warnings, [](const std::string& text) { return text.find("--pin") != text.npos; }));
}

TEST(Pins, BesideTheBodyHoldNothingAndSaySo) {
  const auto none = held({}), beside = held({"x<-5%"}), near = held({"x<-0.1%"});
  for (const auto* setup : {&beside, &near}) {
    EXPECT_EQ(setup->scene.grid.rest, none.scene.grid.rest);
    EXPECT_EQ(setup->scene.grid.fill, none.scene.grid.fill);
    EXPECT_EQ(setup->scene.pinned, none.scene.pinned);
    EXPECT_TRUE(setup->scene.dependent.empty());
    EXPECT_TRUE(warns(*setup, "holds nothing"));
    EXPECT_TRUE(warns(*setup, "0..1, 0..0.2, 0..0.2 m"));
  }
}

TEST(Pins, OnAFaceOfTheBodyPinTheNodesInIt) {
  const auto setup = held({"x<0%"});
  EXPECT_TRUE(setup.scene.dependent.empty());
  int64_t pinned = 0;
  for (int64_t n = 0; n < setup.scene.pinned.rows(); ++n) pinned += setup.scene.pinned(n);
  EXPECT_EQ(pinned, 25);
}

TEST(Pins, KeepThePointsOfTheAssetBehindTheirBordersAtRest) {
  const auto setup = held({"x<1%", "x>99%"});
  const CarriedPoints points = carried_points(setup);
  Array<double> x = setup.scene.grid.rest, u(points.count, 3), F(points.count, 9);
  for (int64_t k = 0; k < x.size(); ++k) x.data()[k] += 0.01 * double(k % 7);
  deform_asset(setup.scene.grid, points.embedding, x, u);
  deformation_gradient(setup.scene.grid, points.embedding, x, F);
  int held_points = 0;
  for (int64_t p = 0; p < points.count; ++p) {
    if (setup.body.carried(p, 0) < 0.985) continue;
    ++held_points;
    for (int d = 0; d < 3; ++d) EXPECT_EQ(u(p, d), 0);
    for (int k = 0; k < 9; ++k) EXPECT_EQ(F(p, k), k % 4 == 0);
  }
  EXPECT_EQ(held_points, 4);
}

TEST(Pins, OfRunsOnTheCardHoldAtTheirBordersToo) {
  RunDescription run = run_of({"x<1%", "x>99%"});
  run.solver.device = Device::kCuda;
  const auto setup = set_up(long_bar(), run);
  EXPECT_EQ(setup.scene.dependent.count(), held({"x<1%", "x>99%"}).scene.dependent.count());
  EXPECT_FALSE(warns(setup, "cuts voxels"));
}

TEST(Pins, OfStepsThatHoldNodesSaySoOnce) {
  RunDescription run = run_of({"x<1%", "x>99%", "sphere(50%,50%,50%,0.07m)"});
  run.solver.mode = SolverMode::kPaper;
  const auto setup = set_up(long_bar(), run);
  EXPECT_TRUE(setup.scene.dependent.empty());
  EXPECT_TRUE(warns(setup, "the solver 'paper' holds the nodes in it only"));
  EXPECT_EQ(std::ranges::count_if(
                setup.warnings,
                [](const std::string& text) { return text.find("cuts voxels") != text.npos; }),
            1);
}

TEST(Pins, HoldFiniteElementsOnVoxelsWhereTheyHoldTheNetwork) {
  const auto network = held({"x<1%", "x>99%"});
  for (const fem::Element element :
       {fem::Element::kVoxel, fem::Element::kHex, fem::Element::kHexBbar}) {
    RunDescription run = run_of({"x<1%", "x>99%"});
    run.fem = FemOptions{.element = element, .named = true, .statics = true};
    run.holds.push_back(parse_hold("z<0%: z"));
    const auto setup = set_up(long_bar(), run);
    EXPECT_EQ(setup.scene.grid.rest, network.scene.grid.rest);
    EXPECT_EQ(setup.scene.pinned, network.scene.pinned);
    EXPECT_FALSE(warns(setup, "--pin"));
    EXPECT_FALSE(warns(setup, "nothing holds"));
    // dependent nodes follow whatever else holds them, and their voxels are cut
    const fem::FemScene scene = fem_scene(setup, run);
    EXPECT_EQ(scene.dependent.count(), network.scene.dependent.count());
    for (int64_t i = 0; i < scene.dependent.count(); ++i)
      for (int d = 0; d < 3; ++d) EXPECT_EQ(scene.fixed(scene.dependent.node(i), d), 0);
    EXPECT_EQ(scene.mesh.part.empty(), element == fem::Element::kVoxel);
    EXPECT_TRUE(unheld_pieces(scene).empty());
  }
}

TEST(Pins, OfFiniteElementsLetTheBarSagAlikeAtBothEnds) {
  for (const bool statics : {true, false}) {
    RunDescription run = run_of({"x<1%", "x>99%"});
    run.fem = FemOptions{.statics = statics};
    run.material = {.young = 1e6, .poisson = 0.3, .density = 1000};
    run.gravity = Vec3{0, -9.81, 0};
    if (!statics) run.scheme = TimeScheme::kAuto;
    const auto setup = set_up(long_bar(), run);
    std::vector<std::string> notes;
    const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
    stepper->begin({});
    const StepReport report = stepper->advance();
    EXPECT_TRUE(report.converged);
    const VoxelGrid& grid = setup.scene.grid;
    Array<double> points(2, 3), u(2, 3);
    for (int p = 0; p < 2; ++p) points(p, 0) = p ? 0.75 : 0.25, points(p, 1) = points(p, 2) = 0.1;
    deform_asset(grid, embed(grid, points), stepper->state().x, u);
    EXPECT_LT(u(0, 1), -1e-5);
    EXPECT_NEAR(u(0, 1), u(1, 1), 0.005 * std::abs(u(0, 1)));
  }
}

}  // namespace
}  // namespace elastogen
