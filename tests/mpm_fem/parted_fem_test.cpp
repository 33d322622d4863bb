// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/parted_fem.hpp"

#include "core/error.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using fem::FemState;
using fem::FemStepReport;
using fem::ImplicitFem;
using test::Element;
using test::FemScene;

/// A block of metal that is torn by its velocities.
FemScene torn_block(double dt) {
  FemScene scene = test::scene_of(test::block(Element::kHex, 2, 2, 2, 0.1),
                                  test::solid(Law::kHencky, 1e6, 0.3, 1000));
  scene.yields = {MetalYield{.stress = 2e3, .hardening = 1e4}};
  scene.dt = dt;
  return scene;
}

FemState torn(const FemScene& scene) {
  FemState state = rest_state(scene);
  test::Random random(1);
  std::normal_distribution<double> normal(0, 3);
  for (int64_t k = 0; k < state.v.size(); ++k) state.v.data()[k] = normal(random);
  return state;
}

bool same_bits(const FemState& a, const FemState& b) {
  return a.u == b.u && a.v == b.v && a.u_before == b.u_before && a.v_before == b.v_before &&
         a.time == b.time && a.steps == b.steps && a.plastic.memory == b.plastic.memory &&
         a.plastic.Fp_inverse == b.plastic.Fp_inverse && a.plastic_work == b.plastic_work;
}

TEST(PartedFem, AStepThatConvergesIsTakenWhole) {
  const FemScene scene = torn_block(4e-3);
  ImplicitFem solver(scene);
  FemState whole = torn(scene), parted = whole;
  for (int k = 0; k < 3; ++k) {
    const FemStepReport one = solver.step(whole), all = step_in_parts(solver, parted);
    EXPECT_TRUE(one.converged);
    EXPECT_TRUE(same_bits(whole, parted)) << k;
    EXPECT_EQ(all.parts, 1);
    EXPECT_EQ(all.halvings, 0);
    EXPECT_EQ(all.outer, one.outer);
    EXPECT_EQ(all.step, one.step);
    EXPECT_EQ(all.time, one.time);
    EXPECT_EQ(all.energy.plastic, one.energy.plastic);
  }
}

/// The fewest Newton steps with which the block's first step is halved once and its parts converge.
int steps_of_half(const FemScene& scene) {
  for (int most = 1; most < 100; ++most) {
    ImplicitFem solver(scene, {.max_newton = most});
    FemState state = torn(scene);
    const FemStepReport report = step_in_parts(solver, state);
    if (report.converged && report.parts == 2) return most;
  }
  return 0;
}

TEST(PartedFem, AStepThatFailsIsTakenInHalves) {
  const FemScene scene = torn_block(4e-3);
  const int most = steps_of_half(scene);
  ASSERT_GT(most, 0);
  ImplicitFem solver(scene, {.max_newton = most});
  FemState state = torn(scene), tried = state;
  EXPECT_FALSE(solver.step(tried).converged);
  const FemStepReport report = step_in_parts(solver, state);
  EXPECT_EQ(report.halvings, 1);
  EXPECT_GT(report.outer, most);  // the work of the try too

  // as two steps of half the time, the flow of each kept once
  const FemScene half = torn_block(2e-3);
  ImplicitFem other(half, {.max_newton = most});
  const FemState start = torn(half);
  FemState twice = start;
  other.step(twice);
  other.step(twice);
  EXPECT_EQ(state.u, twice.u);
  EXPECT_EQ(state.plastic.memory, twice.plastic.memory);
  EXPECT_EQ(state.plastic.Fp_inverse, twice.plastic.Fp_inverse);
  EXPECT_EQ(state.plastic_work, twice.plastic_work);
  // counted as one, with the state a whole step before for BDF2
  EXPECT_EQ(state.steps, 1);
  EXPECT_EQ(state.time, 4e-3);
  EXPECT_EQ(state.u_before, start.u);
  EXPECT_EQ(state.v_before, start.v);
}

TEST(PartedFem, WhatNeverConvergesIsADraftOfSixteenParts) {
  const FemScene scene = torn_block(4e-3);
  ImplicitFem solver(scene, {.max_newton = 0});
  FemState state = torn(scene);
  const FemStepReport report = step_in_parts(solver, state);
  EXPECT_FALSE(report.converged);
  EXPECT_TRUE(report.finite);
  EXPECT_EQ(report.parts, 16);
  // four halvings before the first, one again before every other of the pairs
  EXPECT_GE(report.halvings, 4);
  EXPECT_EQ(state.steps, 1);
}

/// A block without weight on which a plate comes from below; its step is 10 ms.
FemScene block_and_plate() {
  FemScene scene = torn_block(1e-2);
  scene.mesh = test::block(Element::kTet4, 1, 1, 1, 0.1);
  scene.fixed = Array<uint8_t>(scene.mesh.rest.rows(), 3);
  const int64_t count = scene.mesh.rest.rows();
  fem::ContactPoints& points = scene.contact;
  points.nodes = Array<int32_t>(count);
  points.weights = points.area = points.stiffness = Array<double>(count);
  points.position = scene.mesh.rest;
  for (int64_t n = 0; n < count; ++n) points.nodes(n) = int32_t(n);
  points.weights.fill(1), points.area.fill(2.5e-3), points.stiffness.fill(1e5);
  points.layer = 0.02, points.slip_range = 1e-4;
  scene.colliders = {half_space({0, 1, 0}, -0.35, 0)};
  return scene;
}

TEST(PartedFem, CollidersAreWhereTheyAreAtTheEndsOfTheParts) {
  // a plate that goes 2.5 edges in the step: three parts, and the contact of each from its own
  // start
  FemScene scene = block_and_plate();
  Collider& plate = scene.colliders[0];
  plate.path = {{0, {0, 0, 0}}, {1e-2, {0, 0.25, 0}}};
  ImplicitFem solver(scene);
  FemState state = rest_state(scene);
  const double edge = solver.edge();
  const FemStepReport report = step_in_parts(solver, state);
  EXPECT_EQ(report.parts, int(std::ceil(0.25 / edge)));
  // the plate stopped before it reached the body, whichever part it was in
  EXPECT_EQ(state.u, Array<double>(scene.mesh.rest.rows(), 3));

  // a part alone sees the plate as it is then
  plate.path = {{0, {0, 0, 0}}, {5e-3, {0, 0.355, 0}}, {1e-2, {0, 0, 0}}};
  ImplicitFem back(scene);
  state = rest_state(scene);
  back.step_part(state, 5e-3);
  EXPECT_GT(state.u(0, 1), 0);  // the layer reaches the body
  state = rest_state(scene);
  back.step(state);
  EXPECT_EQ(state.u(0, 1), 0);  // at the end of the step the plate is gone
}

TEST(PartedFem, ACollidersWayWhereItTouchesIsATenthOfAnEdge) {
  FemScene scene = block_and_plate();
  Collider& plate = scene.colliders[0];
  const double edge = ImplicitFem(scene).edge();
  // the ways end 5 mm inside the block; a step has at most 16 parts
  for (const auto& [way, parts] : {std::pair{0.3 * edge, 3}, {0.95 * edge, 10}, {2.5 * edge, 16}}) {
    plate.path = {{0, {0, 0, 0}}, {1e-2, {0, way, 0}}};
    plate.centre = {0, 0.005 - way, 0};
    ImplicitFem solver(scene);
    FemState state = rest_state(scene);
    EXPECT_EQ(step_in_parts(solver, state).parts, parts) << way;
    EXPECT_GT(state.u(0, 1), 0) << way;
  }
  // one that withdraws touches at the start
  plate.path = {{0, {0, 0, 0}}, {1e-2, {0, -0.3 * edge, 0}}};
  plate.centre = {0, 0.005, 0};
  ImplicitFem solver(scene);
  FemState state = rest_state(scene);
  EXPECT_EQ(step_in_parts(solver, state).parts, 3);
}

TEST(PartedFem, StepsOnTrueForcesFallBackOnFrozenOnesAndAreCounted) {
  FemScene scene = torn_block(1e-2);
  scene.yields = {SnowYield{.slope = 1.85, .cohesion = 1, .pressure = 5e3}};
  int frozen = 0;
  for (const double speed : {3.0, 6.0}) {
    ImplicitFem solver(scene, {.tolerance = 1e-3, .max_newton = 40});
    FemState state = torn(scene);
    for (int64_t k = 0; k < state.v.size(); ++k) state.v.data()[k] *= speed;
    const FemStepReport report = step_in_parts(solver, state);
    EXPECT_TRUE(report.converged) << speed << ": " << report.residual;
    EXPECT_GE(report.fallbacks, report.halvings);
    frozen += report.fallbacks - report.halvings;
  }
  EXPECT_GT(frozen, 0);
}

TEST(PartedFem, GivenUpOrRefusedItLeavesTheState) {
  const FemScene scene = torn_block(4e-3);
  ImplicitFem solver(scene, {.max_newton = 0});
  FemState state = torn(scene);
  const FemState before = state;
  int asked = 0;
  const FemStepReport given_up = step_in_parts(solver, state, [&] { return ++asked > 3; });
  EXPECT_TRUE(given_up.interrupted);
  EXPECT_TRUE(same_bits(state, before));
  state.v.fill(std::nan(""));
  const Array<double> u = state.u;
  EXPECT_FALSE(step_in_parts(solver, state).finite);
  EXPECT_EQ(state.u, u);
  EXPECT_EQ(state.steps, 0);
  EXPECT_THROW(solver.step_part(state, 0), Error);
  EXPECT_THROW(solver.step_part(state, 5e-3), Error);
}

}  // namespace
}  // namespace elastogen
