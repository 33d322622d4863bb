// SPDX-License-Identifier: Apache-2.0
// Motion with colliders by steps that follow their time error, against Coulomb's law and rigid bodies
// and against runs of the CPU with 32 steps a frame.
#include "tests/network/step/motion_machines.hpp"

namespace elastogen::test {
namespace {

void expect_hop(Device device) {
  const MovingScene m = dropped_ball(1e6, 1);
  const std::vector<MotionFrame> run = play_on(device, m, kAuto, 30),
                                 fine = play(m, kSdirk2, 30, 32);
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

void expect_rest(Device device) {
  const MovingScene m = block_on_floor(1e6, 0);
  const std::vector<MotionFrame> run = play_on(device, m, kAuto, 60);
  const double mass = mean_motion(m.scene, m.start).mass;
  EXPECT_LE(solves_a_frame(run), 1.1);
  EXPECT_LT(std::sqrt(2 * run.back().kinetic / mass), 1e-4);
}

/// Way of the centre of mass along x after each frame.
std::vector<double> way_along_x(const Scene& scene, const State& start,
                                const std::vector<MotionFrame>& run) {
  std::vector<double> way;
  const double begin = mean_motion(scene, start).centre[0];
  for (const MotionFrame& f : run) way.push_back(mean_motion(scene, f.state).centre[0] - begin);
  return way;
}

void expect_slope(Device device) {
  const double degree = std::numbers::pi / 180, friction = 0.5;
  // holds: it slips while it lands, then not at all
  const MovingScene holds = block_on_slope(1e6, 20 * degree, friction);
  std::vector<MotionFrame> run = play_on(device, holds, kAuto, 45);
  std::vector<double> way = way_along_x(holds.scene, holds.start, run);
  printf("slope of 20 degrees: slips %.2f mm, then %.1e m in half a second\n", 1e3 * way.back(),
         way.back() - way[29]);
  EXPECT_LT(std::abs(way.back()), 1.2e-3);
  EXPECT_LT(std::abs(way.back() - way[14]), 3e-5);
  EXPECT_LT(std::abs(way.back() - way[29]), 2e-6);
  // a residual of the tolerance leaves velocities of 3e-4 m/s
  EXPECT_LT(std::abs(mean_motion(holds.scene, run.back().state).velocity[0]), 1e-4);
  // slides by g (sin - mu cos) t^2 / 2
  const MovingScene slides = block_on_slope(1e6, 45 * degree, friction);
  way = way_along_x(slides.scene, slides.start, play_on(device, slides, kAuto, 45));
  const double exact = 9.81 * std::sqrt(0.5) * (1 - friction) / 2 * 1.5 * 1.5;
  printf("slope of 45 degrees: %.4f m, exact %.4f\n", way.back(), exact);
  EXPECT_NEAR(way.back(), exact, 0.01 * exact);
}

void expect_stop(Device device) {
  // from 1 m/s to rest: v^2 / (2 mu g)
  MovingScene stops = block_on_slope(1e6, 0, 0.3);
  for (int64_t n = 0; n < stops.start.v.rows(); ++n) stops.start.v(n, 0) = 1;
  std::vector<double> way =
      way_along_x(stops.scene, stops.start, play_on(device, stops, kAuto, 30));
  printf("stops after %.4f m, exact %.4f\n", way.back(), 1 / (0.6 * 9.81));
  EXPECT_NEAR(way.back(), 1 / (0.6 * 9.81), 0.01 / (0.6 * 9.81));
  // rolls by 5/7 g sin t^2 / 2
  const double slope = std::numbers::pi / 18;
  const MovingScene rolls = ball_on_slope(1e6, slope, 0.5);
  way = way_along_x(rolls.scene, rolls.start, play_on(device, rolls, kAuto, 45));
  const double exact = 5.0 / 7 * 9.81 * std::sin(slope) / 2 * 1.5 * 1.5;
  printf("rolls %.4f m, exact %.4f\n", way.back(), exact);
  EXPECT_NEAR(way.back(), exact, 0.03 * exact);
}

TEST(Motion, ABallHopsAsHighAsWithFineSteps) {
  expect_hop(Device::kCpu);
}

TEST(Motion, WhatLiesStaysAtOneSolveAFrame) {
  expect_rest(Device::kCpu);
}

TEST(Motion, ABlockHoldsOnASlopeAndSlidesAsCoulombSays) {
  expect_slope(Device::kCpu);
}

TEST(Motion, ASlidingBlockStopsAndABallRollsAsRigidOnesDo) {
  expect_stop(Device::kCpu);
}

TEST(Motion, StepsEndWhereAColliderStartsToMove) {
  MovingScene m = block_on_floor(1e6, 0);
  Collider& floor = m.scene.colliders[0];
  floor.path = {{0, {}}, {0.05, {}}, {0.081, {0, 0.02, 0}}};
  Scene scene = m.scene;
  scene.scheme = kAuto, scene.dt = kFrame;
  finish_scene(scene);
  Solver solver(scene, {});
  State state = m.start;
  std::vector<double> ends;
  while (state.time < 4.5 * kFrame) {
    ASSERT_TRUE(solver.step(state).converged);
    ends.push_back(state.time);
  }
  for (const double at : {0.05, 0.081, kFrame, 2 * kFrame, 3 * kFrame, 4 * kFrame})
    EXPECT_TRUE(std::any_of(ends.begin(), ends.end(), [&](double t) {
      return std::abs(t - at) < 1e-12;
    })) << at;
}

#ifdef ELASTOGEN_CUDA

TEST_F(MotionOnCard, ABallHopsAsHighAsWithFineSteps) {
  expect_hop(Device::kCuda);
}

TEST_F(MotionOnCard, WhatLiesStaysAtOneSolveAFrame) {
  expect_rest(Device::kCuda);
}

TEST_F(MotionOnCard, ABlockHoldsOnASlopeAndSlidesAsCoulombSays) {
  expect_slope(Device::kCuda);
}

TEST_F(MotionOnCard, ASlidingBlockStopsAndABallRollsAsRigidOnesDo) {
  expect_stop(Device::kCuda);
}

constexpr double kAgreement = 1e-6;  // of the way; a third of the tolerance changes 2e-8 of it

/// Both machines, so exactly that only rounding parts them: the same steps, and the same places.
void expect_agreement(const MovingScene& m, int frames) {
  SolverOptions options{.tolerance = 1e-6, .follows_time_error = false};
  const std::vector<MotionFrame> host = play(m, kAuto, frames, 1, options);
  options.device = Device::kCuda;
  const std::vector<MotionFrame> card = play(m, kAuto, frames, 1, options);
  ASSERT_EQ(host.size(), card.size());
  for (size_t k = 0; k < host.size(); ++k) {
    const double way = rms_distance(m.scene, host[k].state.x, m.start.x);
    EXPECT_EQ(host[k].solves, card[k].solves) << "frame " << k;
    EXPECT_EQ(host[k].steps, card[k].steps) << "frame " << k;
    EXPECT_NEAR(host[k].estimate, card[k].estimate, 0.02 * host[k].estimate + 1e-12)
        << "frame " << k;
    EXPECT_EQ(host[k].state.h_before, card[k].state.h_before) << "frame " << k;
    EXPECT_LT(rms_distance(m.scene, host[k].state.x, card[k].state.x), kAgreement * way)
        << "frame " << k;
  }
}

TEST_F(MotionOnCard, AFallingBallMovesAsOnTheHost) {
  expect_agreement(dropped_ball(1e6, 1), 8);
}

TEST_F(MotionOnCard, ABlockOnASlopeMovesAsOnTheHost) {
  expect_agreement(block_on_slope(1e6, 45 * std::numbers::pi / 180, 0.5), 8);
}

TEST_F(MotionOnCard, APendulumMovesAsOnTheHost) {
  expect_agreement(pendulum(1.2), 12);
}

TEST_F(MotionOnCard, FirstStagesAndBondsAreHandedOutAsByTheHost) {
  MovingScene m = block_on_slope(1e6, 20 * std::numbers::pi / 180, 0.5);
  m.scene.scheme = kSdirk2;
  m.scene.dt = kFrame;
  SolverOptions options;
  options.tolerance = 1e-7;
  Solver host(m.scene, options);
  options.device = Device::kCuda;
  Solver card(m.scene, options);
  host.begin(m.start);
  card.begin(m.start);
  for (int k = 0; k < 6; ++k) host.advance(), card.advance();
  const StageData a = host.stage_data(), b = card.stage_data();
  ASSERT_EQ(a.first.size(), b.first.size());
  ASSERT_EQ(a.bonds.size(), b.bonds.size());
  double held = 0;
  for (int64_t i = 0; i < a.first.size(); ++i) EXPECT_NEAR(a.first.data[i], b.first.data[i], 1e-7);
  for (int64_t i = 0; i < a.bonds.size(); ++i) {
    held = std::max(held, std::abs(a.bonds.data[i]));
    EXPECT_NEAR(a.bonds.data[i], b.bonds.data[i], 1e-7);
  }
  EXPECT_GT(held, 1e-6);
}

#endif

}  // namespace
}  // namespace elastogen::test
