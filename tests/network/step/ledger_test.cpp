// SPDX-License-Identifier: Apache-2.0
// The ledger of runs by stages: what changed momentum and energy, and what nothing accounts for.
#include "tests/network/step/motion_machines.hpp"

namespace elastogen::test {
namespace {

/// The ledger of a run, and the mass of the body.
struct LedgerRun {
  Ledger ledger;
  double mass = 0;

  double loss(double energy) const { return energy / ledger.kinetic; }
};

LedgerRun keep(Device device, const MovingScene& m, TimeScheme scheme, int frames,
               double tolerance = 1e-3, int parts = 1) {
  Scene scene = m.scene;
  scene.scheme = scheme;
  scene.dt = kFrame / parts;
  finish_scene(scene);
  SolverOptions options;
  options.device = device;
  options.tolerance = tolerance;
  options.follows_time_error = tolerance == 1e-3;
  Solver solver(scene, options);
  solver.begin(m.start);
  LedgerRun run;
  run.mass = mean_motion(scene, m.start).mass;
  for (int part = 0; part < frames * parts;) {
    const StepReport r = solver.advance();
    EXPECT_TRUE(r.finite && r.ledger.known);
    if (!r.finite) break;
    run.ledger.add(r.ledger);
    part += r.completes;
  }
  return run;
}

void say(const char* name, const LedgerRun& run) {
  const Ledger& l = run.ledger;
  const StepLedger& s = l.sum;
  printf(
      "%-16s gap %.1e of %.3g N s, %.1e of %.3g N m s; %.4g -> %.4g J, of %.3g J: colliders %.4f, "
      "damped "
      "%.4f, friction %.4f, guard %.4f, scheme %.4f, residual %.1e, correction %.1e, rise %.1e\n",
      name, l.linear_gap, l.linear, l.angular_gap, l.angular, s.start.energy.total(),
      s.end.energy.total(), l.kinetic, run.loss(s.done.colliders), run.loss(s.done.damped),
      run.loss(s.friction()), run.loss(s.guard), run.loss(s.numerical()), run.loss(s.done.residual),
      run.loss(s.correction), run.loss(l.rise));
}

/// A body in flight: nothing but gravity, and momentum to rounding.
void expect_flight(Device device) {
  MovingScene fall = block_on_floor(1e5, 100);
  fall.start = initial_state(fall.scene, {.velocity = {1, 2, 0.5}, .spin = {1, 2, -3}});
  const std::pair<const char*, MovingScene> scenes[] = {
      {"free fall", fall}, {"spin", spinning_ball(50, 10)}, {"tumbling", tumbling_box(50, 6)}};
  for (const auto& [name, scene] : scenes)
    for (const TimeScheme scheme : {kAuto, kSdirk2}) {
      SCOPED_TRACE(name);
      const LedgerRun run = keep(device, scene, scheme, 30);
      say(name, run);
      const Ledger& l = run.ledger;
      const double linear = std::max(l.linear, 0.1 * run.mass);
      EXPECT_LT(l.linear_gap, 1e-12 * linear);
      EXPECT_LT(l.angular_gap, 1e-12 * l.angular);
      for (size_t d = 0; d < 3; ++d)
        EXPECT_NEAR(l.sum.done.gravity.linear[d], scene.scene.gravity[d] * run.mass,
                    1e-11 * linear);
      EXPECT_EQ(safe_norm(l.sum.done.contact.linear), 0);
      EXPECT_EQ(safe_norm(l.sum.done.pins.linear), 0);
      EXPECT_EQ(l.sum.friction(), 0);
      EXPECT_LT(std::abs(run.loss(l.sum.done.residual)), 1e-5);
      EXPECT_LT(std::abs(run.loss(l.sum.correction)), 3e-3);
    }
}

/// Pins hold what swings; the exact impulse of the pins is the change of momentum beyond the weight.
void expect_pendulum(Device device) {
  const MovingScene m = pendulum(1.2);
  for (const TimeScheme scheme : {kAuto, kSdirk2}) {
    const LedgerRun run = keep(device, m, scheme, 45, 1e-8),
                    fine = keep(device, m, kSdirk2, 45, 1e-5, 16);
    say("pendulum", run);
    const Ledger& l = run.ledger;
    EXPECT_LT(l.linear_gap, 1e-6 * l.linear);
    EXPECT_LT(l.angular_gap, 1e-3 * l.angular);
    const Vec3 off = minus(l.sum.done.pins.linear, fine.ledger.sum.done.pins.linear);
    EXPECT_LT(safe_norm(off), 0.03 * l.linear);
    EXPECT_GT(safe_norm(l.sum.done.pins.linear), 5 * l.linear);
    EXPECT_EQ(l.sum.done.moved, 0);
    EXPECT_LT(std::abs(run.loss(l.sum.numerical())), 0.02);
  }
}

/// A ball that bounces, spins, rubs and is damped.
void expect_bounce(Device device) {
  MovingScene m = dropped_ball(1e6, 1);
  for (Material& material : m.scene.materials)
    material.loss_factor = 0.1, material.loss_frequency = 10;
  m.start = initial_state(m.scene, {.velocity = {2, -4.4, 0}, .spin = {0, 0, 10}});
  const LedgerRun run = keep(device, m, kAuto, 30);
  say("bounce", run);
  const Ledger& l = run.ledger;
  const StepLedger& s = l.sum;
  EXPECT_LT(l.linear_gap, 1e-12 * l.linear);
  EXPECT_LT(l.angular_gap, 1e-4 * l.linear);
  // contact: the change of momentum, and the weight
  const Vec3 change = minus(s.end.momentum.linear, s.start.momentum.linear);
  EXPECT_NEAR(s.done.contact.linear[1], change[1] + run.mass * 9.81, 1e-10 * l.linear);
  EXPECT_NEAR(s.done.contact.linear[0], change[0], 1e-10 * l.linear);
  // energy goes, and none comes
  EXPECT_GT(run.loss(s.done.damped), 0.1);
  EXPECT_GT(run.loss(s.friction()), 0.01);
  EXPECT_GT(run.loss(s.numerical()), -1e-3);
  EXPECT_LT(run.loss(l.rise), 1e-3);
  EXPECT_LT(std::abs(run.loss(s.done.residual)), 1e-3);
  EXPECT_LT(std::abs(run.loss(s.correction)), 2e-3);
  EXPECT_EQ(s.done.colliders, 0);
}

/// A block that lies: once it does, nothing flows but its weight into the floor. One that slides
/// heats the floor by mu N times its way.
void expect_block(Device device) {
  const LedgerRun lies = keep(device, block_on_floor(1e6, 0), kAuto, 60);
  const StepLedger& rest = lies.ledger.sum;
  say("lies", lies);
  const double weight = lies.mass * 9.81;
  EXPECT_NEAR(rest.done.contact.linear[1], 2 * weight, 1e-4 * weight);
  EXPECT_LT(std::abs(rest.end.energy.kinetic), 1e-8 * lies.mass);
  EXPECT_LT(lies.ledger.linear_gap, 1e-12 * weight * kFrame);
  const double angle = std::numbers::pi / 4;
  const LedgerRun slides = keep(device, block_on_slope(1e6, angle, 0.5), kAuto, 45);
  say("slides", slides);
  const StepLedger& slip = slides.ledger.sum;
  const double N = weight * std::cos(angle), way = 9.81 * std::sqrt(0.5) * 0.5 / 2 * 1.5 * 1.5;
  EXPECT_NEAR(slip.friction(), 0.5 * N * way, 0.01 * 0.5 * N * way);
  EXPECT_NEAR(slip.done.contact.linear[0], -0.5 * N * 1.5, 0.01 * N);
  EXPECT_LT(std::abs(slides.loss(slip.numerical())), 2e-3);
  const LedgerRun holds = keep(device, block_on_slope(1e6, 0.35, 0.5), kAuto, 45);
  say("holds", holds);
  // it shakes on its layer faster than steps follow: its friction is known roughly
  EXPECT_NEAR(holds.ledger.sum.friction(), 0, 1e-3 * weight * 0.3);
}

/// A block that a floor carries up with a constant velocity, or along by friction.
void expect_carried(Device device) {
  MovingScene m = block_on_floor(1e6, 0);
  m.scene.colliders[0].path = {{0, {}}, {1, {0, 0.6, 0}}};
  const LedgerRun up = keep(device, m, kAuto, 30);
  say("lifted", up);
  const double weight = up.mass * 9.81;
  // m g h, and m v^2 for a body that jumps to v: half of it is lost
  const double kinetic = up.mass * 0.6 * 0.6 / 2;
  EXPECT_NEAR(up.ledger.sum.done.colliders, weight * 0.6 + 2 * kinetic, 0.15 * kinetic);
  EXPECT_NEAR(up.ledger.sum.done.colliders, 0.6 * up.ledger.sum.done.contact.linear[1],
              1e-9 * weight);
  // pulled along: the floor works on the block by mu N v t until it goes along, half of that is heat
  m.scene.colliders[0].path = {{0, {}}, {1, {1, 0, 0}}};
  const LedgerRun along = keep(device, m, kAuto, 24);
  say("pulled along", along);
  const StepLedger& s = along.ledger.sum;
  EXPECT_NEAR(s.end.energy.kinetic, along.mass / 2, 0.01 * along.mass);
  EXPECT_NEAR(s.done.colliders, along.mass, 0.02 * along.mass);
  EXPECT_NEAR(s.friction(), along.mass / 2, 0.05 * along.mass);
  EXPECT_LT(along.ledger.linear_gap, 1e-12 * along.ledger.linear);
}

/// Where the guard takes energy it changes momentum, and the ledger says both.
void expect_guard(Device device) {
  const LedgerRun run = keep(device, dropped_ball(1e8, 1), kAuto, 12);
  say("hard landing", run);
  EXPECT_GT(run.ledger.sum.guard, 0);
  EXPECT_GT(safe_norm(run.ledger.sum.guarded.linear), 0);
  EXPECT_LT(run.ledger.linear_gap, 1e-12 * run.ledger.linear);
  EXPECT_LT(run.loss(run.ledger.rise), 1e-3);
}

TEST(Ledger, FlightKeepsMomentumToRounding) {
  expect_flight(Device::kCpu);
}

TEST(Ledger, PinsHoldWhatSwings) {
  expect_pendulum(Device::kCpu);
}

TEST(Ledger, ABounceClosesAndNoEnergyComes) {
  expect_bounce(Device::kCpu);
}

TEST(Ledger, BlocksLieSlideAndHoldAsCoulombSays) {
  expect_block(Device::kCpu);
}

TEST(Ledger, AFloorThatMovesWorks) {
  expect_carried(Device::kCpu);
}

TEST(Ledger, TheGuardIsAccountedFor) {
  expect_guard(Device::kCpu);
}

TEST(Ledger, TheSolverLeavesLittleInAllScenes) {
  const MovingScene swings[] = {released_cantilever(1e5), vibrating_bar(16, 0.05),
                                vibrating_bar(8, 0.05), spinning_ball(5, 10)};
  for (const MovingScene& m : swings) {
    const LedgerRun run = keep(Device::kCpu, m, kAuto, 30);
    say("swings", run);
    EXPECT_LT(std::abs(run.loss(run.ledger.sum.done.residual)), 2e-3);
    EXPECT_GT(run.loss(run.ledger.sum.numerical()), -1e-3);
  }
  for (const auto& [young, height] : {std::pair{1e6, 1.0}, {1e6, 3.0}, {1e5, 1.0}, {3e5, 2.0}}) {
    const LedgerRun run = keep(Device::kCpu, dropped_ball(young, height), kAuto, 30);
    say("drop", run);
    EXPECT_LT(std::abs(run.loss(run.ledger.sum.done.residual)), 1e-3);
    EXPECT_LT(std::abs(run.loss(run.ledger.sum.correction)), 1e-3);
    EXPECT_GT(run.loss(run.ledger.sum.numerical()), -1e-3);
    EXPECT_LT(run.loss(run.ledger.rise), 1e-3);
    EXPECT_LT(run.ledger.linear_gap, 1e-12 * run.ledger.linear);
  }
}

#ifdef ELASTOGEN_CUDA

using LedgerOnCard = OnCard;

TEST_F(LedgerOnCard, FlightKeepsMomentumToRounding) {
  expect_flight(Device::kCuda);
}

TEST_F(LedgerOnCard, PinsHoldWhatSwings) {
  expect_pendulum(Device::kCuda);
}

TEST_F(LedgerOnCard, ABounceClosesAndNoEnergyComes) {
  expect_bounce(Device::kCuda);
}

TEST_F(LedgerOnCard, BlocksLieSlideAndHoldAsCoulombSays) {
  expect_block(Device::kCuda);
}

TEST_F(LedgerOnCard, AFloorThatMovesWorks) {
  expect_carried(Device::kCuda);
}

TEST_F(LedgerOnCard, TheGuardIsAccountedFor) {
  expect_guard(Device::kCuda);
}

#endif

}  // namespace
}  // namespace elastogen::test
