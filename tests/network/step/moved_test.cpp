// SPDX-License-Identifier: Apache-2.0
// Parts that are moved, and loads. Against the reference of held_test.cpp: the bar 1 x 0.2 x 0.2 m with a
// hundredth of its length held at both ends, E 1, nu 0.3, of which a pull by 1 m takes the force 0.041313
// and a turn by 1 rad the torque 8.885e-5 where both are small.
#include "tests/network/held_scenes.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen::test {
namespace {

constexpr double kMovedEdge = 0.05, kYoung = 1e8;
constexpr double kForce = 0.041313 * kYoung, kTorque = 8.885e-5 * kYoung;

const std::vector<Border> kEnds = {half_space_border(true, 0.01), half_space_border(false, 0.99)};

Holder shift(const Vec3& by, double time) {
  Holder holder;
  holder.path = {{0, {}}, {time, by}};
  return holder;
}

Holder turn(double angle, double time) {
  Holder holder = shift({angle, 0, 0}, time);
  holder.turns = true;
  holder.centre = {0, 0.1, 0.1};
  return holder;
}

/// The bar without weight, its left end at rest, the other one held by `holder`; its border at the left
/// is an offset [voxels] behind a layer of nodes, and with 0.4 that at the right is in one.
Scene moved_bar(double offset, const Holder& holder, double dt = 100) {
  Scene scene = held_scene(box_surface({0, 0, 0}, {1, 0.2, 0.2}), kEnds, kMovedEdge,
                           {0.01 - offset * kMovedEdge, 0.02, 0.02}, dt);
  scene.gravity = {};
  scene.holders = {Holder{}, holder};
  scene.holder = Array<int32_t>(scene.grid.node_count());
  for (int64_t n = 0; n < scene.holder.rows(); ++n)
    scene.holder(n) = scene.pinned(n) ? scene.grid.rest(n, 0) > 0.5 : -1;
  finish_scene(scene);
  return scene;
}

/// The largest distance of points of the moved face from where they should be.
double face_error(const Scene& scene, const State& state) {
  const std::vector<Vec3> points = {{0.99, 0.01, 0.03}, {0.99, 0.19, 0.11}, {0.99, 0.1, 0.2}};
  const Array<double> u = displacements(scene, state, points);
  double worst = 0;
  for (size_t p = 0; p < points.size(); ++p) {
    const Vec3 wanted = held_displacement(scene.holders[1], points[p], state.time);
    for (size_t d = 0; d < 3; ++d)
      worst = std::max(worst, std::abs(u(int64_t(p), int(d)) - wanted[d]));
  }
  return worst;
}

TEST(MovedBar, PullTakesTheForceOfTheReferenceOnAnyGrid) {
  const double pull = 1e-4;
  for (const double offset : {0.0, 1e-4, 0.3, 0.4, 0.5, 0.9}) {
    const Scene scene = moved_bar(offset, shift({pull, 0, 0}, 50));
    StepReport report;
    const State state = equilibrium(scene, &report);
    ASSERT_EQ(report.reactions.size(), 2u);
    for (const int end : {0, 1}) {
      const Vec3& force = report.reactions[size_t(end)].force;
      EXPECT_NEAR((end == 1 ? 1 : -1) * force[0] / (kForce * pull), 1, 0.006) << offset;
      EXPECT_LT(std::abs(force[1]) + std::abs(force[2]), 1e-3 * std::abs(force[0]));
    }
    EXPECT_LT(face_error(scene, state), 1e-6 * pull);
  }
}

TEST(MovedBar, TurnTakesTheTorqueOfTheReferenceOnAnyGrid) {
  const double angle = 1e-3;
  for (const double offset : {0.0, 0.3, 0.4, 0.7}) {
    const Scene scene = moved_bar(offset, turn(angle, 50));
    StepReport report;
    const State state = equilibrium(scene, &report);
    // the element's own error at four voxels across, 5.6 %
    EXPECT_NEAR(report.reactions[1].moment[0] / (kTorque * angle), 1.0558, 0.01) << offset;
    EXPECT_NEAR(report.reactions[0].moment[0] / (kTorque * angle), -1.0558, 0.01) << offset;
    EXPECT_LT(face_error(scene, state), 1e-6 * angle * 0.1);
  }
}

TEST(MovedBar, LargeTurnsAndPullsDoNotDependOnTheGrid) {
  double least[2] = {1e300, 1e300}, most[2] = {};
  for (const double offset : {0.0, 0.25, 0.4, 0.5, 0.9}) {
    StepReport report;
    const Scene turned = moved_bar(offset, turn(std::numbers::pi / 2, 50));
    EXPECT_LT(face_error(turned, equilibrium(turned, &report, 1e-6)), 1e-9);
    const double torque = report.reactions[1].moment[0] / kYoung;
    const Scene pulled = moved_bar(offset, shift({0.3, 0, 0}, 50));
    EXPECT_LT(face_error(pulled, equilibrium(pulled, &report, 1e-6)), 1e-9);
    const double force = report.reactions[1].force[0] / kYoung;
    for (const auto& [k, value] : {std::pair(0, torque), {1, force}})
      least[k] = std::min(least[k], value), most[k] = std::max(most[k], value);
  }
  EXPECT_LT(most[0], 1.002 * least[0]);
  EXPECT_LT(most[1], 1.006 * least[1]);
  // of the reference, whose neo-Hookean law has another volumetric part
  EXPECT_NEAR(most[0], 1.6152e-4, 0.03 * 1.6152e-4);
  EXPECT_NEAR(most[1], 0.01025, 0.03 * 0.01025);
}

TEST(MovedBar, ReactionsCarryTheWeightOfTheFreePart) {
  for (const double offset : {0.0, 0.4}) {
    Scene scene = moved_bar(offset, Holder{});
    scene.gravity = {1, -9.81, 2};
    StepReport report;
    equilibrium(scene, &report, 1e-8);
    // held voxels of the border that the grid fits weigh on their pin alone
    const double weight = 1000 * 0.98 * 0.2 * 0.2;
    for (size_t d = 0; d < 3; ++d)
      EXPECT_NEAR(report.reactions[0].force[d] + report.reactions[1].force[d],
                  -weight * scene.gravity[d], 1e-6 * 9.81 * weight)
          << offset;
  }
}

TEST(MovedBar, MovesWithItsOnlyPinAsOneBody) {
  const Vec3 speed = {0.3, -0.2, 0.5};
  for (const TimeScheme scheme :
       {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2, TimeScheme::kAuto}) {
    Scene scene = moved_bar(0.4, shift({0.3, -0.2, 0.5}, 1), 1.0 / 60);
    scene.materials[0] = solid(1e6, 0.3);
    scene.scheme = scheme;
    scene.holders[0] = scene.holders[1];  // both ends go along
    finish_scene(scene);
    Solver solver(scene, {.tolerance = 1e-6});
    State state = initial_state(scene, {{speed[0], speed[1], speed[2]}, {}});
    while (state.time < 0.5) {
      const StepReport report = solver.step(state);
      ASSERT_TRUE(report.converged) << int(scheme);
      for (const Reaction& reaction : report.reactions)
        for (const double force : reaction.force) EXPECT_LT(std::abs(force), 1e-3);
    }
    for (int64_t n = 0; n < state.x.rows(); ++n)
      for (int d = 0; d < 3; ++d) {
        EXPECT_NEAR(state.x(n, d) - scene.grid.rest(n, d), speed[size_t(d)] * state.time, 1e-8);
        EXPECT_NEAR(state.v(n, d), speed[size_t(d)], 1e-6);
      }
  }
}

TEST(MovedBar, WorkOfTheHolderIsInTheLedger) {
  for (const double offset : {0.4, 0.3})  // pinned nodes, and dependent ones
    for (const bool turns : {false, true}) {
      Holder holder = turns ? turn(1.0, 0.5) : shift({0.1, 0.05, 0}, 0.5);
      holder.path.eases = true;
      Scene scene = moved_bar(offset, holder, 1.0 / 60);
      scene.materials[0] = solid(1e6, 0.3);
      scene.gravity = {0, -9.81, 0};
      scene.scheme = TimeScheme::kAuto;
      finish_scene(scene);
      Solver solver(scene, {.tolerance = 1e-4});
      State state = initial_state(scene);
      Ledger ledger;
      while (state.time < 0.6) ledger.add(solver.step(state).ledger);
      const double brought = ledger.sum.done.moved;
      EXPECT_GT(brought, 1);
      const double gain = ledger.sum.end.energy.total() - ledger.sum.start.energy.total();
      EXPECT_NEAR(gain, brought, 0.02 * brought) << offset << ' ' << turns;
      EXPECT_LT(ledger.linear_gap, 1e-3 * ledger.linear);
    }
}

TEST(MovedBar, SchemesAndSolversAgree) {
  Holder holder = shift({0.05, 0.1, 0}, 0.25);
  holder.path.eases = true;
  Array<double> first;
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
    for (const TimeScheme scheme : {TimeScheme::kSdirk2, TimeScheme::kAuto}) {
      Scene scene = moved_bar(0.6, holder, 1.0 / 120);
      scene.materials[0] = solid(1e6, 0.3);
      scene.scheme = scheme;
      finish_scene(scene);
      Solver solver(scene, {.mode = mode, .tolerance = 1e-5});
      State state = initial_state(scene);
      while (state.time < 0.25 - 1e-9) ASSERT_TRUE(solver.step(state).converged);
      const Array<double> u = displacements(scene, state, {{0.5, 0.1, 0.1}, {0.7, 0, 0.2}});
      if (first.empty()) first = u;
      for (int64_t k = 0; k < u.size(); ++k)
        EXPECT_NEAR(u.data()[k], first.data()[k], 0.02 * 0.1) << int(mode) << ' ' << int(scheme);
    }
}

/// A free block on whose upper corner nodes a force acts.
Scene pushed_block(TimeScheme scheme) {
  Scene scene = scene_on(voxelize(box_surface({0, 0, 0}, {0.4, 0.2, 0.2}), {.h = 0.05}).grid,
                         solid(1e5, 0.3));
  scene.scheme = scheme;
  scene.dt = 1.0 / 60;
  scene.load = Array<double>(scene.grid.node_count(), 3);
  for (int64_t n = 0; n < scene.load.rows(); ++n)
    if (scene.grid.rest(n, 0) > 0.39 && scene.grid.rest(n, 1) > 0.19)
      scene.load(n, 2) = 0.3, scene.load(n, 1) = -0.1;
  finish_scene(scene);
  return scene;
}

TEST(Load, BringsItsImpulseAndItsMoment) {
  for (const TimeScheme scheme :
       {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2, TimeScheme::kAuto}) {
    const Scene scene = pushed_block(scheme);
    Solver solver(scene, {.tolerance = 1e-5});
    State state = initial_state(scene);
    Ledger ledger;
    while (state.time < 0.2 - 1e-9) {
      const StepReport report = solver.step(state);
      ASSERT_TRUE(report.converged);
      ledger.add(report.ledger);
    }
    // all momentum is that of the load
    Vec3 momentum = {}, force = {};
    for (int64_t n = 0; n < state.v.rows(); ++n)
      for (size_t d = 0; d < 3; ++d) {
        momentum[d] += scene.mass(n) * state.v(n, int(d));
        force[d] += scene.load(n, int(d));
      }
    for (size_t d = 0; d < 3; ++d)
      EXPECT_NEAR(momentum[d], force[d] * state.time, 1e-9) << int(scheme);
    if (!has_stages(scheme)) continue;
    EXPECT_LT(ledger.linear_gap, 1e-12);
    EXPECT_LT(ledger.angular_gap, 1e-12);
    EXPECT_GT(safe_norm(ledger.sum.end.momentum.angular), 0.02);
    // but for the waves of the sudden load, which the scheme damps
    EXPECT_NEAR(ledger.sum.end.energy.total(), ledger.sum.done.loaded,
                0.04 * ledger.sum.done.loaded);
  }
}

TEST(Load, AtRestItStretchesABarByHooke) {
  Scene scene = moved_bar(0, Holder{});
  // the right end is free, and pulled evenly
  const double area = 0.2 * 0.2, force = 1e-4 * kYoung * area;
  double all = 0;
  scene.dependent = {};
  for (int64_t n = 0; n < scene.pinned.rows(); ++n) {
    if (scene.grid.rest(n, 0) > 0.5) scene.pinned(n) = kFreeNode, scene.holder(n) = -1;
    if (scene.grid.rest(n, 0) > 0.97) all += scene.mass(n);
  }
  scene.load = Array<double>(scene.grid.node_count(), 3);
  for (int64_t n = 0; n < scene.pinned.rows(); ++n)
    if (scene.grid.rest(n, 0) > 0.97) scene.load(n, 0) = force * scene.mass(n) / all;
  finish_scene(scene);
  StepReport report;
  const State state = equilibrium(scene, &report);
  const Array<double> u = displacements(scene, state, {{0.3, 0.1, 0.1}, {0.7, 0.1, 0.1}});
  EXPECT_NEAR(u(1, 0) - u(0, 0), 0.4e-4, 0.005 * 0.4e-4);
  EXPECT_NEAR(report.reactions[0].force[0], -force, 1e-4 * force);
}

}  // namespace
}  // namespace elastogen::test
