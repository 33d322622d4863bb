// SPDX-License-Identifier: Apache-2.0
// Bodies with ends that move, or under loads, on the device against the CPU. Nothing is here in
// builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "tests/network/contact/contact_scenes.hpp"
#include "tests/network/fixed_scenes.hpp"
#include "tests/network/potential/device_potential_support.hpp"
#include "tests/network/step/moving_scenes.hpp"

namespace elastogen::test {
namespace {

using MovedOnCard = OnCard;

std::vector<Scene> moved_scenes(TimeScheme scheme) {
  return {pulled_bar(scheme), twisted_bar(scheme, false), twisted_bar(scheme, true),
          loaded_bar(scheme), sliding_bar(scheme)};
}

/// Forces to a part of the largest force, moments to that of the largest moment.
void expect_reactions(const std::vector<Reaction>& found, const std::vector<Reaction>& expected,
                      double bound) {
  ASSERT_EQ(found.size(), expected.size());
  double force = 0, moment = 0;
  for (const Reaction& of : expected)
    force = std::max(force, safe_norm(of.force)), moment = std::max(moment, safe_norm(of.moment));
  EXPECT_GT(force, 0);
  EXPECT_GT(moment, 0);
  for (size_t h = 0; h < found.size(); ++h)
    for (size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR(found[h].force[d], expected[h].force[d], bound * force);
      EXPECT_NEAR(found[h].moment[d], expected[h].moment[d], bound * moment);
      EXPECT_NEAR(found[h].about[d], expected[h].about[d], bound);
    }
}

/// Gradients and reactions at a random displacement that holders allow.
void expect_residual_of_host(const Scene& scene) {
  IncrementalPotential host(scene);
  cuda::DevicePotential device(host);
  State state = state_at(scene, followed(scene, random_field(scene, 0.02 * kHeldEdge, 5)));
  state.time = 0.06;
  host.begin_step(state, {TimeScheme::kEuler, scene.dt, 1});
  device.begin_step(host);
  std::vector<double> u = random_field(scene, 0.02 * kHeldEdge, 6), expected(u.size());
  host.held().place(u.data());
  const PotentialValue value = host.residual(u.data(), expected.data());
  OnDevice<double> place(u), gradient(std::vector<double>(u.size(), 7));
  device.start_residual(place.data(), gradient.data());
  const std::vector<double> found = gradient.host();
  EXPECT_NEAR(device.value().elastic, value.elastic, 1e-11 * value.elastic);
  EXPECT_NEAR(device.value().contact, value.contact, 1e-11 * value.contact);
  EXPECT_LT(relative_difference(found, expected), 1e-11);
  for (int64_t n = 0; n < scene.pinned.rows(); ++n)
    for (int64_t d = 0; d < 3 && scene.pinned(n); ++d) EXPECT_EQ(found[size_t(3 * n + d)], 0);
  expect_reactions(device.reactions(), host.reactions(), 1e-11);
}

TEST_F(MovedOnCard, ReactionsAtADisplacementAreThoseOfTheHost) {
  for (Scene& scene : moved_scenes(TimeScheme::kEuler))
    for (const double loss : {0.0, 0.1}) {
      SCOPED_TRACE(concat(scene.dependent.count(), " dependent nodes, loss factor ", loss));
      scene.materials[0].loss_factor = loss;
      expect_residual_of_host(scene);
    }
}

TEST_F(MovedOnCard, ReactionsCountContactAtPinnedNodes) {
  Scene scene = twisted_bar(TimeScheme::kEuler, false);
  // the bar lies in a part of the layer on the floor
  const double bottom = 0.02 - kHeldEdge, layer = kHeldEdge / 4;
  scene.surface = face_points(scene.grid);
  scene.colliders = {half_space({0, 1, 0}, bottom + 0.3 * layer, 0.3)};
  scene.holders[0] = {};
  finish_scene(scene);
  IncrementalPotential host(scene);
  std::vector<double> force(3 * size_t(scene.grid.node_count())), u(force.size());
  host.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  ASSERT_GT(host.contact().evaluate(u.data(), force.data(), true), 0);
  double at_pinned = 0;
  for (int64_t n = 0; n < scene.pinned.rows(); ++n)
    if (scene.pinned(n) == kPinnedNode) at_pinned += std::abs(force[size_t(3 * n + 1)]);
  ASSERT_GT(at_pinned, 0.01 * norm(force));
  expect_residual_of_host(scene);
}

TEST_F(MovedOnCard, StepsOfAllSchemesAndSolversAreThoseOfTheHost) {
  for (const TimeScheme scheme : kMovedSchemes)
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
      for (const Scene& scene : moved_scenes(scheme)) {
        SCOPED_TRACE(concat(scheme_name(scheme), ", ", solver_name(mode), ", ",
                            scene.dependent.count(), " dependent nodes"));
        const MovedRun a = run_moved(scene, mode, Device::kCpu, 11),
                       b = run_moved(scene, mode, Device::kCuda, 11);
        EXPECT_EQ(b.state.time, a.state.time);
        EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-6);
        EXPECT_LT(relative_difference(b.state.v, a.state.v), 1e-5);
        EXPECT_NEAR(b.kinetic, a.kinetic, 1e-4 * a.kinetic);
        EXPECT_NEAR(b.elastic, a.elastic, 1e-4 * a.elastic);
        expect_reactions(b.reactions, a.reactions, 1e-4);
        EXPECT_NEAR(b.moved, a.moved, 1e-4 * std::abs(a.moved));
        EXPECT_NEAR(b.loaded, a.loaded, 1e-4 * std::abs(a.loaded));
        expect_held(scene, b.state);
      }
}

TEST_F(MovedOnCard, AFreeBodyUnderALoadTakesUpItsImpulse) {
  for (const TimeScheme scheme : kMovedSchemes) {
    SCOPED_TRACE(scheme_name(scheme));
    Scene scene = falling_bar(scheme);
    add_load(scene);
    const MovedRun a = run_moved(scene, SolverMode::kNewton, Device::kCpu, 6),
                   b = run_moved(scene, SolverMode::kNewton, Device::kCuda, 6);
    // nothing resists the turn of a free body: in steps without references it is known to the tolerance
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), has_stages(scheme) ? 1e-6 : 2e-5);
    EXPECT_NEAR(b.loaded, a.loaded, 1e-5 * std::abs(a.loaded));
    const Vec3 gained = total_momentum(scene, b.state), force = force_on(scene);
    for (size_t d = 0; d < 3; ++d)
      EXPECT_NEAR(gained[d], b.state.time * force[d], 1e-12 * safe_norm(force));
  }
}

TEST_F(MovedOnCard, RunsRepeatToTheBit) {
  for (const TimeScheme scheme : {TimeScheme::kBdf2, TimeScheme::kAuto})
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
      for (const Scene& scene : moved_scenes(scheme)) {
        const MovedRun a = run_moved(scene, mode, Device::kCuda, 8),
                       b = run_moved(scene, mode, Device::kCuda, 8);
        EXPECT_EQ(a.state.x, b.state.x);
        EXPECT_EQ(a.state.v, b.state.v);
        EXPECT_EQ(a.moved, b.moved);
        for (size_t h = 0; h < a.reactions.size(); ++h) {
          EXPECT_EQ(a.reactions[h].force, b.reactions[h].force);
          EXPECT_EQ(a.reactions[h].moment, b.reactions[h].moment);
        }
      }
}

TEST_F(MovedOnCard, HoldersAtRestChangeNoBit) {
  for (const TimeScheme scheme : kMovedSchemes)
    for (const double offset : {0.0, 0.7}) {
      const Scene held = moved_bar(scheme, offset, {}), plain = swinging_bar(scheme, offset);
      const MovedRun a = run_moved(held, SolverMode::kQuasi, Device::kCuda, 6),
                     b = run_moved(plain, SolverMode::kQuasi, Device::kCuda, 6);
      EXPECT_EQ(a.state.x, b.state.x);
      EXPECT_EQ(a.state.v, b.state.v);
      EXPECT_EQ(a.kinetic, b.kinetic);
      EXPECT_EQ(a.reactions.size(), 2u);
      EXPECT_TRUE(b.reactions.empty());
    }
}

TEST_F(MovedOnCard, AutoTakesTheCardToo) {
  for (const Scene& scene : moved_scenes(TimeScheme::kAuto)) {
    SolverOptions options;
    options.device = Device::kAuto;
    EXPECT_NE(Solver(scene, options).device(), "cpu");
  }
}

}  // namespace
}  // namespace elastogen::test

#endif
