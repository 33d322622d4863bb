// SPDX-License-Identifier: Apache-2.0
// The ledger of finite elements by stages, as tests/network/step/ledger_test.cpp; and what pins that
// move and loads do, which only they have.
#include "tests/mpm_fem/stage_scenes.hpp"

#include <numbers>

namespace elastogen::test {
namespace {

using fem::FemScene;
using fem::FemState;
using fem::FemStepReport;
using fem::Scheme;
using fem::StageFem;

Ledger keep(FemScene scene, FemState state, Scheme scheme, int frames, int parts = 1,
            double tolerance = 1e-6) {
  scene.scheme = scheme;
  scene.dt = kFrame / parts;
  StageFem solver(scene, stage_options(tolerance));
  Ledger ledger;
  for (int part = 0; part < frames * parts;) {
    const FemStepReport r = solver.step(state);
    EXPECT_TRUE(r.finite && r.ledger.known);
    if (!r.finite) break;
    ledger.add(r.ledger);
    part += r.completes;
  }
  return ledger;
}

Ledger keep(const MovingScene& m, Scheme scheme, int frames) {
  const FemScene scene = as_fem(m.scene);
  return keep(scene, as_fem(scene, m.start), scheme, frames);
}

void say(const char* name, const Ledger& l) {
  const StepLedger& s = l.sum;
  const double K = l.kinetic;
  printf(
      "%-16s gap %.1e of %.3g N s, %.1e of %.3g N m s; %.4g -> %.4g J, of %.3g J: colliders "
      "%.4f, pins %.4f, loads %.4f, damped %.4f, friction %.4f, guard %.4f, scheme %.4f, residual "
      "%.1e, correction %.1e, rise %.1e\n",
      name, l.linear_gap, l.linear, l.angular_gap, l.angular, s.start.energy.total(),
      s.end.energy.total(), K, s.done.colliders / K, s.done.moved / K, s.done.loaded / K,
      s.done.damped / K, s.friction() / K, s.guard / K, s.numerical() / K, s.done.residual / K,
      s.correction / K, l.rise / K);
}

TEST(StageLedger, FlightKeepsMomentumToRounding) {
  for (const bool spins : {false, true}) {
    MovingScene m = spins ? tumbling_box(50, 6) : small_ball(1e5, 1);
    if (!spins) m.scene.colliders.clear();
    for (const Scheme scheme : {Scheme::kAuto, Scheme::kSdirk2}) {
      const Ledger l = keep(m, scheme, 15);
      say(spins ? "tumbling" : "free fall", l);
      EXPECT_LT(l.linear_gap, 1e-12 * std::max(l.linear, 1.0));
      EXPECT_LT(l.angular_gap, 1e-12 * std::max(l.angular, 0.1 * l.linear));
      EXPECT_LT(std::abs(l.sum.done.residual), 1e-6 * l.kinetic);
    }
  }
}

TEST(StageLedger, PinsHoldWhatSwings) {
  for (const Scheme scheme : {Scheme::kAuto, Scheme::kSdirk2}) {
    const Ledger l = keep(small_pendulum(1.2), scheme, 30);
    say("pendulum", l);
    // the forces at the pins themselves, not what is left of the balance
    EXPECT_LT(l.linear_gap, 1e-5 * l.linear);
    EXPECT_LT(l.angular_gap, 1e-3 * l.angular);
    EXPECT_EQ(l.sum.done.moved, 0);
  }
}

TEST(StageLedger, ABounceClosesAndNoEnergyComes) {
  MovingScene m = small_ball(1e6, 1);
  for (Material& material : m.scene.materials)
    material.loss_factor = 0.1, material.loss_frequency = 10;
  for (int64_t n = 0; n < m.start.v.rows(); ++n) m.start.v(n, 0) = 1;
  const Ledger l = keep(m, Scheme::kAuto, 16);
  say("bounce", l);
  const StepLedger& s = l.sum;
  EXPECT_LT(l.linear_gap, 1e-12 * l.linear);
  EXPECT_GT(s.done.damped, 0.05 * l.kinetic);
  EXPECT_GT(s.friction(), 1e-3 * l.kinetic);
  EXPECT_GT(s.numerical(), -1e-3 * l.kinetic);
  EXPECT_LT(l.rise, 1e-3 * l.kinetic);
  EXPECT_LT(std::abs(s.done.residual), 1e-3 * l.kinetic);
  EXPECT_LT(std::abs(s.correction), 2e-3 * l.kinetic);
}

TEST(StageLedger, NetworkAndFiniteElementsKeepTheSame) {
  const MovingScene m = small_ball(1e6, 1);
  Scene scene = m.scene;
  scene.scheme = TimeScheme::kSdirk2, scene.dt = kFrame / 8;
  finish_scene(scene);
  SolverOptions options;
  options.tolerance = 1e-7;
  Solver solver(scene, options);
  State state = m.start;
  Ledger network;
  for (int k = 0; k < 32; ++k) network.add(solver.step(state).ledger);
  const FemScene elements = as_fem(m.scene);
  const Ledger fem = keep(elements, as_fem(elements, m.start), Scheme::kSdirk2, 4, 8, 1e-7);
  const StepLedger &a = network.sum, &b = fem.sum;
  const double K = fem.kinetic;
  EXPECT_NEAR(a.friction(), b.friction(), 1e-4 * K);
  EXPECT_NEAR(a.numerical(), b.numerical(), 1e-4 * K);
  EXPECT_NEAR(a.correction, b.correction, 1e-4 * K);
  EXPECT_NEAR(a.end.energy.total(), b.end.energy.total(), 1e-4 * K);
  for (size_t d = 0; d < 3; ++d) {
    EXPECT_NEAR(a.done.contact.linear[d], b.done.contact.linear[d], 1e-4 * fem.linear);
    EXPECT_NEAR(a.done.contact.angular[d], b.done.contact.angular[d], 1e-4 * fem.linear);
  }
}

/// A block of which one face is carried along x by a path.
FemScene dragged(const std::function<double(double)>& path) {
  MovingScene m{scene_on(make_box(4, 2, 2, 0.1), solid(1e7, 0.3)), {}};
  for (int64_t n = 0; n < m.scene.grid.node_count(); ++n)
    m.scene.pinned(n) = m.scene.grid.node_coord(n, 0) == 0;
  m.scene.gravity = {};
  finish_scene(m.scene);
  FemScene scene = as_fem(m.scene);
  scene.motion = [&, path](double time, Out<double> u) {
    for (int64_t n = 0; n < u.rows; ++n) u(n, 0) = path(time);
  };
  return scene;
}

TEST(StageLedger, PinsThatMoveWork) {
  // from rest to a speed and on: the work is the energy that the block has got
  const double T = 10 * kFrame, v = 1.5;
  const FemScene scene = dragged([=](double t) {
    return t < T ? v * (t / 2 - T / (2 * std::numbers::pi) * std::sin(std::numbers::pi * t / T))
                 : v * (t - T / 2);
  });
  for (const Scheme scheme : {Scheme::kAuto, Scheme::kSdirk2}) {
    const Ledger l =
        keep(scene, fem::rest_state(scene), scheme, 14, scheme == Scheme::kAuto ? 1 : 8);
    say("dragged", l);
    const double kinetic = 1000 * 0.4 * 0.2 * 0.2 * v * v / 2;
    EXPECT_NEAR(l.sum.end.energy.kinetic, kinetic, 0.02 * kinetic);
    EXPECT_NEAR(l.sum.done.moved, kinetic, 0.02 * kinetic);
    EXPECT_NEAR(l.sum.done.pins.linear[0], 1000 * 0.4 * 0.2 * 0.2 * v, 0.02 * l.linear);
    EXPECT_LT(l.linear_gap, 0.02 * l.linear);
  }
}

TEST(StageLedger, AFloorCarriesABlockUp) {
  // at a constant acceleration in sixteenths of a frame: m (g + a) s, and what the block lost
  MovingScene m = small_block(0);
  m.scene.colliders[0].path.keys.clear();
  for (int k = 0; k <= 60; ++k) {
    const double t = k * kFrame / 4;
    m.scene.colliders[0].path.keys.push_back({t, {0, t * t, 0}});
  }
  const Ledger l = keep(m, Scheme::kAuto, 15);
  say("carried", l);
  const double mass = 1000 * 0.24 * 0.16 * 0.24, way = 0.25;
  EXPECT_NEAR(l.sum.done.colliders, mass * (9.81 + 2) * way, 0.02 * mass * 11.81 * way);
  EXPECT_NEAR(l.sum.end.momentum.linear[1], mass * 1, 0.05 * mass);
  EXPECT_LT(l.linear_gap, 1e-12 * l.linear);
}

TEST(StageLedger, LoadsWork) {
  FemScene scene = as_fem(small_ball(1e6, 1).scene);
  scene.colliders.clear();
  scene.gravity = {};
  const Array<double> mass = scene.mass;
  scene.force = [mass](double, Out<double> force) {
    for (int64_t n = 0; n < force.rows; ++n) force(n, 0) = 3 * mass(n);
  };
  const Ledger l = keep(scene, fem::rest_state(scene), Scheme::kAuto, 15);
  say("loaded", l);
  double all = 0;
  for (int64_t n = 0; n < mass.rows(); ++n) all += mass(n);
  const double t = 15 * kFrame;
  EXPECT_NEAR(l.sum.done.loads.linear[0], 3 * all * t, 1e-9 * all);
  EXPECT_NEAR(l.sum.done.loaded, all * 9 * t * t / 2, 1e-3 * all);
  EXPECT_LT(l.linear_gap, 1e-12 * l.linear);
}

}  // namespace
}  // namespace elastogen::test
