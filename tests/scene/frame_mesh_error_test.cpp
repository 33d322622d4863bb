// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "scene/run.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// A bar of 16 x 4 x 4 cm that is held at one end.
RunDescription bar() {
  RunDescription run;
  run.shape =
      BodyShape{.kind = BodyShape::Kind::kBox, .lower = {0, 0, 0}, .upper = {0.16, 0.04, 0.04}};
  run.h = 0.01;
  run.material.young = 1e5;
  run.pins = {parse_pin("x<5%")};
  run.frames = 3;
  run.solver.device = Device::kCpu;
  run.energy = EnergySource::kAnalytic;
  return run;
}

TEST(FrameMeshError, EveryFrameOnTheHostGetsANumber) {
  std::vector<std::optional<MeshError>> numbers;
  ClipHooks hooks;
  hooks.on_progress = [&](int64_t, const FrameCertificate& c) { numbers.push_back(c.mesh_error); };
  const RunReport report = run_scene(bar(), hooks).report;
  ASSERT_EQ(numbers.size(), 3);
  double largest = 0;
  for (const auto& number : numbers) {
    ASSERT_TRUE(number);
    EXPECT_GT(number->rms, 0);
    EXPECT_LE(number->rms, number->largest);
    largest = std::max(largest, number->largest);
  }
  EXPECT_EQ(report.mesh_error.frames, 3);
  EXPECT_EQ(report.mesh_error.largest, largest);
  EXPECT_GT(report.mesh_error.largest_motion, largest);
}

TEST(FrameMeshError, ARunMayLeaveItOut) {
  RunDescription run = bar();
  run.mesh_error = false;
  EXPECT_EQ(run_scene(run).report.mesh_error.frames, 0);
}

TEST(FrameMeshError, FiniteElementsOnTheSameVoxelsHaveTheSameNumber) {
  RunDescription network = bar();
  network.solver.tolerance = 1e-8;
  network.scheme = TimeScheme::kBdf2;
  RunDescription elements = network;
  elements.fem.emplace();
  const RunMeshError a = run_scene(network).report.mesh_error;
  const RunMeshError b = run_scene(elements).report.mesh_error;
  EXPECT_NEAR(a.rms, b.rms, 1e-4 * b.rms);
  // other elements have none
  elements.fem->element = fem::Element::kTet4;
  EXPECT_EQ(run_scene(elements).report.mesh_error.frames, 0);
}

/// An equilibrium, with a face that is moved and a face that slides.
TEST(FrameMeshError, AnEquilibriumWithHoldsAndMovesGetsANumber) {
  RunDescription run = bar();
  run.fem = FemOptions{.statics = true};
  run.frames = 1;
  run.pins.clear();
  run.holds = {parse_hold("x<1%: x"), parse_hold("box(-1,-1,-1, 0.1,0.0006,1): y"),
               parse_hold("box(-1,-1,-1, 0.1,1,0.0006): z")};
  run.gravity = Vec3{};
  run.moves = {parse_move("x>99%: shift 0:0,0,0; 1:0.02,0,0")};
  const RunMeshError stretched = run_scene(run).report.mesh_error;
  ASSERT_EQ(stretched.frames, 1);
  // but for the gripped end the stress is uniform
  EXPECT_LT(stretched.rms, 0.002);
}

}  // namespace
}  // namespace elastogen::test
