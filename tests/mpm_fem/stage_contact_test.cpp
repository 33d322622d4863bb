// SPDX-License-Identifier: Apache-2.0
// Steps of stages in contact, and how they are refused.
#include "core/error.hpp"
#include "tests/mpm_fem/stage_scenes.hpp"

#include <algorithm>
#include <numbers>

namespace elastogen::test {
namespace {

using fem::FemScene;
using fem::FemState;
using fem::FemStepReport;
using fem::Scheme;
using fem::StageFem;

constexpr double kDegree = std::numbers::pi / 180;

TEST(StageContact, ABallHopsAsHighAsWithFineSteps) {
  const MovingScene m = small_ball(1e6, 1);
  const std::vector<MotionFrame> run = play(m, Scheme::kAuto, 16),
                                 fine = play(m, Scheme::kSdirk2, 16, 32);
  const auto hop = [&](const std::vector<MotionFrame>& frames) {
    double low = 1e300, high = -1e300;
    for (const MotionFrame& f : frames) {
      const double y = mean_motion(m.scene, f.state).centre[1];
      if (y < low) low = y, high = y;
      high = std::max(high, y);
    }
    return high - 0.2 - m.scene.colliders[0].centre[1];  // of its lowest point above the floor
  };
  printf("hop %.4f m, fine %.4f m, %.2f solves a frame\n", hop(run), hop(fine),
         solves_a_frame(run));
  EXPECT_NEAR(hop(run), hop(fine), 0.03 * hop(fine));
  // friction takes energy; none comes from nowhere
  double low = 1e300, most = 0;
  for (const MotionFrame& f : run) {
    low = std::min(low, f.energy);
    most = std::max(most, f.energy - low);
  }
  EXPECT_LT(most, 1e-3 * 9.81 * mean_motion(m.scene, m.start).mass);
}

TEST(StageContact, AHardLandingBringsNoEnergy) {
  // a frame is far too long for this ball: without its guard a step would bring 3.6 J of 630
  const MovingScene m = small_ball(1e8, 1);
  FemScene scene = as_fem(m.scene);
  scene.scheme = Scheme::kAuto, scene.dt = kFrame;
  StageFem solver(scene, stage_options(1e-3));
  FemState state = as_fem(scene, m.start);
  for (int64_t n = 0; n < state.v.rows(); ++n) state.v(n, 0) = 1;
  double last = 1e300, most = 0;
  int guarded = 0;
  while (state.time < 4 * kFrame) {
    const FemStepReport r = solver.step(state);
    ASSERT_TRUE(r.converged && r.finite);
    const EnergyParts& e = r.energy;
    const double energy = e.kinetic + e.elastic + e.hourglass + e.gravity + e.contact;
    most = std::max(most, energy - last);
    last = energy;
    guarded += r.guarded;
  }
  EXPECT_LT(most, 1e-4 * mean_motion(m.scene, m.start).mass * 9.81 * 0.4);
  EXPECT_GT(guarded, 0);
}

TEST(StageContact, WhatLiesStaysAtOneSolveAFrame) {
  const MovingScene m = small_block(0);
  const std::vector<MotionFrame> run = play(m, Scheme::kAuto, 45);
  const double mass = mean_motion(m.scene, m.start).mass;
  double solves = 0;
  for (size_t k = 30; k < run.size(); ++k) solves += run[k].solves;
  printf("lies at %.1e m/s, %.2f solves a frame\n", std::sqrt(2 * run.back().kinetic / mass),
         solves / 15);
  EXPECT_LE(solves, 1.1 * 15);
  EXPECT_LT(std::sqrt(2 * run.back().kinetic / mass), 1e-4);
}

/// Way of the centre of mass along x after each frame.
std::vector<double> way_along_x(const MovingScene& m, const std::vector<MotionFrame>& run) {
  std::vector<double> way;
  const double begin = mean_motion(m.scene, m.start).centre[0];
  for (const MotionFrame& f : run) way.push_back(mean_motion(m.scene, f.state).centre[0] - begin);
  return way;
}

TEST(StageContact, ABlockHoldsOnASlopeAndSlidesAsCoulombSays) {
  // holds: it slips while it lands, then not at all
  const MovingScene holds = block_on_slope(1e6, 20 * kDegree, 0.5);
  const std::vector<MotionFrame> run = play(holds, Scheme::kAuto, 45, 1, 1e-5);
  std::vector<double> way = way_along_x(holds, run);
  const double speed = mean_motion(holds.scene, run.back().state).velocity[0];
  printf("slope of 20 degrees: slips %.2f mm, then %.1e m/s\n", 1e3 * way.back(), speed);
  EXPECT_LT(std::abs(way.back()), 1.2e-3);
  EXPECT_LT(std::abs(way.back() - way[14]), 3e-5);
  EXPECT_LT(std::abs(speed), 1e-5);
  // slides by g (sin - mu cos) t^2 / 2
  const MovingScene slides = small_block(45 * kDegree);
  way = way_along_x(slides, play(slides, Scheme::kAuto, 45));
  const double exact = 9.81 * std::sqrt(0.5) * 0.5 / 2 * 1.5 * 1.5;
  printf("slope of 45 degrees: %.4f m, exact %.4f\n", way.back(), exact);
  EXPECT_NEAR(way.back(), exact, 0.01 * exact);
}

/// A block that lies still, from steps of implicit Euler.
FemState at_rest(FemScene scene) {
  scene.scheme = Scheme::kEuler, scene.dt = kFrame;
  fem::ImplicitFem integrator(scene, {.tolerance = 1e-9, .as_positions = true});
  FemState state = fem::rest_state(scene);
  for (int k = 0; k < 60; ++k) integrator.step(state);
  FemState result = fem::rest_state(scene);
  result.u = state.u;
  return result;
}

TEST(StageContact, WhatLiesStillHoldsAtAnyStepUpToCoulombsPull) {
  // no vibration helps or hurts: from rest, pulled along the floor by a force that grows in 10
  // frames to a share of mu m g, then stays
  const MovingScene m = small_block(0);
  const FemState rest = at_rest(as_fem(m.scene));
  for (const int parts : {1, 4})
    for (const double share : {0.9, 1.1}) {
      FemScene scene = as_fem(m.scene);
      scene.force = [&](double time, Out<double> force) {
        const double pull = share * 0.5 * 9.81 * std::min(1.0, time / (10 * kFrame));
        for (int64_t n = 0; n < force.rows; ++n) force(n, 0) = pull * m.scene.mass(n);
      };
      FemState state = rest;
      std::vector<double> way =
          way_along_x(m, play(scene, state, Scheme::kSdirk2, 30, parts, 1e-6));
      printf("%g of mu m g, %d steps a frame: %.4f mm after 15 frames, %.4f mm after 30\n", share,
             parts, 1e3 * way[14], 1e3 * way[29]);
      if (share < 1) {  // what is left swings; smoothed friction would creep by 0.3 mm
        EXPECT_NEAR(way[29], way[14], 2e-5);
        continue;
      }
      // a rigid block, whose acceleration grows to a within t, then stays for T
      const double a = 0.1 * 0.5 * 9.81, t = 10 * kFrame * (1 - 1 / share), T = 20 * kFrame;
      EXPECT_NEAR(way[29], a * (T * T / 2 + T * t / 2 + t * t / 6), 0.05 * way[29]);
    }
}

TEST(StageContact, StepsEndWhereAColliderStartsToMove) {
  const MovingScene m = small_block(0);
  FemScene scene = as_fem(m.scene);
  scene.colliders[0].path = {{0, {}}, {0.05, {}}, {0.081, {0, 0.02, 0}}};
  scene.scheme = Scheme::kAuto, scene.dt = kFrame;
  StageFem solver(scene, stage_options(1e-3));
  FemState state = fem::rest_state(scene);
  std::vector<double> ends;
  int intervals = 0;
  while (state.time < 3.5 * kFrame) {
    const FemStepReport r = solver.step(state);
    ASSERT_TRUE(r.converged && r.finite);
    EXPECT_EQ(r.time, state.time);
    ends.push_back(state.time);
    intervals += r.completes;
  }
  EXPECT_EQ(intervals, 4);
  for (const double at : {0.05, 0.081, kFrame, 2 * kFrame, 3 * kFrame, 4 * kFrame})
    EXPECT_TRUE(std::any_of(ends.begin(), ends.end(), [&](double t) {
      return std::abs(t - at) < 1e-12;
    })) << at;
}

TEST(StageContact, AStepKnowsNothingButTheState) {
  // through an impact with friction, where steps are rejected: another solver makes the same bits
  const MovingScene m = small_ball(1e6, 1);
  FemScene scene = as_fem(m.scene);
  scene.scheme = Scheme::kAuto, scene.dt = kFrame;
  StageFem one(scene, stage_options(1e-3));
  FemState state = as_fem(scene, m.start);
  for (int64_t n = 0; n < state.v.rows(); ++n) state.v(n, 0) = 1;
  while (state.time < 1.5 * kFrame) ASSERT_TRUE(one.step(state).finite);
  ASSERT_GT(std::count_if(state.stages.bonds.data(),
                          state.stages.bonds.data() + state.stages.bonds.size(),
                          [](double slip) { return slip != 0; }),
            0);
  FemState again = state;
  StageFem other(scene, stage_options(1e-3));
  int rejected = 0;
  for (int k = 0; k < 12; ++k) {
    const FemStepReport r = one.step(state), s = other.step(again);
    rejected += r.rejected;
    EXPECT_EQ(r.solves, s.solves);
    EXPECT_EQ(r.time_error, s.time_error);
  }
  EXPECT_GT(rejected, 0);
  EXPECT_EQ(state.u, again.u);
  EXPECT_EQ(state.v, again.v);
  EXPECT_EQ(state.stages.bonds, again.stages.bonds);
}

/// Whether a step leaves a state as it was.
void expect_the_same(const FemState& a, const FemState& b) {
  EXPECT_EQ(a.u, b.u);
  EXPECT_EQ(a.v, b.v);
  EXPECT_EQ(a.u_before, b.u_before);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.steps, b.steps);
  EXPECT_EQ(a.stages.bonds, b.stages.bonds);
  EXPECT_EQ(a.stages.h_before, b.stages.h_before);
  EXPECT_EQ(a.stages.control.level(), b.stages.control.level());
}

TEST(StageContact, AStepThatIsRefusedOrStoppedLeavesTheState) {
  // the floor rises into a block whose lower nodes are pinned
  MovingScene m = small_block(0);
  for (int64_t n = 0; n < m.scene.grid.node_count(); ++n)
    m.scene.pinned(n) = m.scene.grid.node_coord(n, 1) == 0;
  for (const Scheme scheme : {Scheme::kSdirk2, Scheme::kAuto}) {
    FemScene scene = as_fem(m.scene);
    scene.scheme = scheme, scene.dt = kFrame;
    scene.colliders[0].path = {{0, {}}, {kFrame, {}}, {kFrame * 1.01, {0, 0.1, 0}}};
    StageFem solver(scene, stage_options(1e-3));
    FemState state = fem::rest_state(scene);
    ASSERT_TRUE(solver.step(state).finite);
    while (state.time < 0.99 * kFrame) ASSERT_TRUE(solver.step(state).finite);
    const FemState before = state;
    FemStepReport report = solver.step(state, [] { return true; });
    EXPECT_TRUE(report.interrupted);
    expect_the_same(state, before);
    report = solver.step(state);
    EXPECT_FALSE(report.finite);
    EXPECT_FALSE(report.refusal.empty());
    expect_the_same(state, before);
  }
}

TEST(StageContact, BadScenesAreRefused) {
  FemScene scene = as_fem(small_block(0).scene);
  EXPECT_THROW(StageFem{scene}, Error);  // implicit Euler has no stages
  scene.scheme = Scheme::kAuto;
  EXPECT_THROW(fem::ImplicitFem{scene}, Error);
  EXPECT_THROW(StageFem(scene, {.time_error = 0}), Error);
  FemState state = fem::rest_state(scene);
  state.v = {};
  StageFem solver(scene);
  EXPECT_THROW(solver.step(state), Error);
  // a material that yields
  scene.mesh = fem::voxel_mesh(small_block(0).scene, fem::Element::kHexBbar);
  scene.yields = {MetalYield{}};
  EXPECT_THROW(StageFem{scene}, Error);
}

}  // namespace
}  // namespace elastogen::test
