// SPDX-License-Identifier: Apache-2.0
// Wind: the drag of plates and balls, and the fall of a plate through air.
#include "core/loads.hpp"
#include "core/state.hpp"
#include "tests/network/held_scenes.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen::test {
namespace {

constexpr double kAir = 1.2;

/// A closed box in air of a constant velocity, without weight.
Scene box_in_wind(const Vec3& lower, const Vec3& upper, double h, const Vec3& velocity) {
  const Surface surface = box_surface(lower, upper);
  Scene scene = scene_on(voxelize(surface, {.h = h}).grid, solid(1e6, 0.3));
  scene.materials[0].density = 30;
  scene.dt = 1.0 / 60;
  scene.wind.velocity = {{0, velocity}};
  add_wind_surface(scene.grid, surface, scene.wind);
  finish_scene(scene);
  return scene;
}

Vec3 whole_force(const Scene& scene, const State& state) {
  NodeLoads loads(scene);
  loads.begin_step(state.x.data(), state.v.data(), 0, 1e-6);
  loads.set_time(0);
  Vec3 sum = {};
  for (int64_t n = 0; n < state.x.rows(); ++n)
    for (size_t d = 0; d < 3; ++d) sum[d] += loads.data()[3 * n + int64_t(d)];
  return sum;
}

TEST(Wind, PressesOnAPlateWithADragCoefficientOfOne) {
  const Scene scene = box_in_wind({0, 0, 0}, {1, 0.1, 0.6}, 0.1, {0, -7, 0});
  const Vec3 force = whole_force(scene, initial_state(scene));
  EXPECT_NEAR(force[1], -kAir / 2 * 49 * 0.6, 1e-9);
  EXPECT_NEAR(force[0], 0, 1e-12);
  // along the plate it feels its edge alone, and relative velocity counts
  const Scene along = box_in_wind({0, 0, 0}, {1, 0.1, 0.6}, 0.1, {9, 0, 0});
  EXPECT_NEAR(whole_force(along, initial_state(along, {{4, 0, 0}, {}}))[0], kAir / 2 * 25 * 0.06,
              1e-9);
}

TEST(Wind, OnATurnedPlateActsAlongItsNormal) {
  const Scene scene = box_in_wind({0, 0, 0}, {1, 0.1, 0.6}, 0.1, {0, -7, 0});
  // turned by 30 degrees about z
  const double angle = std::numbers::pi / 6, s = std::sin(angle), c = std::cos(angle);
  State state = initial_state(scene);
  for (int64_t n = 0; n < state.x.rows(); ++n) {
    const double x = state.x(n, 0), y = state.x(n, 1);
    state.x(n, 0) = c * x - s * y, state.x(n, 1) = s * x + c * y;
  }
  const Vec3 force = whole_force(scene, state);
  const double broad = kAir / 2 * 49 * c * c * 0.6, edge = kAir / 2 * 49 * s * s * 0.06;
  EXPECT_NEAR(force[0], s * broad - c * edge, 1e-9);
  EXPECT_NEAR(force[1], -c * broad - s * edge, 1e-9);
}

TEST(Wind, OfOpenSurfacesPressesOnOneSideInFull) {
  Scene scene = box_in_wind({0, 0, 0}, {1, 0.1, 0.6}, 0.1, {0, -7, 0});
  scene.wind.share = 1;
  EXPECT_NEAR(whole_force(scene, initial_state(scene))[1], -kAir * 49 * 0.6, 1e-9);
}

TEST(Wind, BringsNoNodeBeyondTheAirInAStep) {
  const Scene scene = box_in_wind({0, 0, 0}, {1, 0.1, 0.6}, 0.1, {0, -7, 0});
  const State state = initial_state(scene);
  NodeLoads loads(scene);
  const double h = 1e6;
  loads.begin_step(state.x.data(), state.v.data(), 0, h);
  loads.set_time(0);
  for (int64_t n = 0; n < state.x.rows(); ++n)
    EXPECT_GE(loads.data()[3 * n + 1] * h / scene.mass(n), -7 * (1 + 1e-12));
}

TEST(Wind, BodiesThatGoWithItFeelNothing) {
  const Vec3 W = {3, -1, 2};
  const Scene scene = box_in_wind({0, 0, 0}, {0.4, 0.1, 0.3}, 0.1, W);
  const Vec3 force = whole_force(scene, initial_state(scene, {{3, -1, 2}, {}}));
  for (const double f : force) EXPECT_LT(std::abs(f), 1e-12);
}

TEST(Wind, APlateFallsThroughAirAsItsDragSays) {
  for (const TimeScheme scheme : {TimeScheme::kSdirk2, TimeScheme::kAuto, TimeScheme::kBdf2}) {
    Scene scene = box_in_wind({-0.5, 0, -0.5}, {0.5, 0.1, 0.5}, 0.1, {});
    scene.gravity = {0, -9.81, 0};
    scene.scheme = scheme;
    finish_scene(scene);
    Solver solver(scene, {.tolerance = 1e-5});
    State state = initial_state(scene);
    Ledger ledger;
    while (state.time < 1.5 - 1e-9) {
      const StepReport report = solver.step(state);
      ASSERT_TRUE(report.converged);
      ledger.add(report.ledger);
    }
    const double steady = std::sqrt(2 * 3.0 * 9.81 / kAir);  // 3 kg a square metre
    const double fall = steady * steady / 9.81 * std::log(std::cosh(9.81 * 1.5 / steady));
    // how far it fell in the mean
    double mean = 0, mass = 0;
    for (int64_t n = 0; n < state.x.rows(); ++n) {
      mean += scene.mass(n) * (scene.grid.rest(n, 1) - state.x(n, 1));
      mass += scene.mass(n);
    }
    EXPECT_NEAR(mean / mass / fall, 1, 0.02) << int(scheme);
    if (!has_stages(scheme)) continue;
    EXPECT_LT(ledger.linear_gap, 1e-9);
    const double lost = ledger.sum.start.energy.total() - ledger.sum.end.energy.total();
    EXPECT_NEAR(-ledger.sum.done.loaded / lost, 1, 0.01);
  }
}

}  // namespace
}  // namespace elastogen::test
