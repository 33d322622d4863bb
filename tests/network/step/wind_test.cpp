// SPDX-License-Identifier: Apache-2.0
// Wind: the drag of plates, the fall of a plate through air and its order in time, long steps of light
// bodies, and what wind brings to a pin.
#include "core/node_loads.hpp"
#include "core/state.hpp"
#include "tests/network/wind_scenes.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <tuple>

namespace elastogen::test {
namespace {

constexpr double kAir = 1.2;

Vec3 whole_force(const Scene& scene, const State& state) {
  NodeLoads loads(scene);
  loads.begin(0, 0);
  loads.start_wind(state.x.data(), state.v.data());
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

TEST(Wind, OfLongStepsIsThatOfTheirEnd) {
  // v = h rho/2 (W - v)^2 / s of a plate of s = 3 kg/m^2, by implicit Euler
  for (const double h : {0.02, 0.1, 0.5}) {
    Scene scene = box_in_wind({0, 0, 0}, {0.6, 0.1, 0.6}, 0.1, {0, -7, 0});
    scene.dt = h;
    Solver solver(scene, {.tolerance = 1e-6});
    State state = initial_state(scene);
    ASSERT_TRUE(solver.step(state).converged) << h;
    const double a = h * kAir / 2 / 3, v = 7 + (1 - std::sqrt(1 + 28 * a)) / (2 * a);
    double mean = 0;
    for (int64_t n = 0; n < state.v.rows(); ++n) mean -= state.v(n, 1) / double(state.v.rows());
    EXPECT_NEAR(mean / v, 1, 1e-4) << h;
  }
}

TEST(Wind, BodiesThatGoWithItFeelNothing) {
  const Vec3 W = {3, -1, 2};
  const Scene scene = box_in_wind({0, 0, 0}, {0.4, 0.1, 0.3}, 0.1, W);
  const Vec3 force = whole_force(scene, initial_state(scene, {{3, -1, 2}, {}}));
  for (const double f : force) EXPECT_LT(std::abs(f), 1e-12);
}

/// How far a plate of 3 kg a square metre is off where it should be after falling for 1.6 s [of the way].
double fall_error(TimeScheme scheme, double dt, Ledger* ledger) {
  Scene scene = box_in_wind({-0.5, 0, -0.5}, {0.5, 0.1, 0.5}, 0.1, {});
  scene.gravity = {0, -9.81, 0};
  scene.scheme = scheme;
  scene.dt = dt;
  finish_scene(scene);
  Solver solver(scene, {.tolerance = 1e-7});
  State state = initial_state(scene);
  while (state.time < 1.6 - 1e-9) {
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.converged);
    if (ledger) ledger->add(report.ledger);
  }
  const double steady = std::sqrt(2 * 3.0 * 9.81 / kAir);
  const double fall = steady * steady / 9.81 * std::log(std::cosh(9.81 * 1.6 / steady));
  double mean = 0, mass = 0;
  for (int64_t n = 0; n < state.x.rows(); ++n) {
    mean += scene.mass(n) * (scene.grid.rest(n, 1) - state.x(n, 1));
    mass += scene.mass(n);
  }
  return mean / mass / fall - 1;
}

TEST(Wind, APlateFallsThroughAirAsItsDragSaysToTheOrderOfTheScheme) {
  for (const auto& [scheme, order, most] :
       {std::tuple(TimeScheme::kEuler, 1.0, 0.02), std::tuple(TimeScheme::kBdf2, 2.0, 2e-3),
        std::tuple(TimeScheme::kSdirk2, 2.0, 5e-4)}) {
    const double coarse = fall_error(scheme, 0.08, nullptr),
                 fine = fall_error(scheme, 0.04, nullptr);
    EXPECT_LT(std::abs(fine), most) << int(scheme);
    EXPECT_NEAR(std::log2(std::abs(coarse / fine)), order, 0.25) << int(scheme);
  }
}

TEST(Wind, OfStepsThatFollowTheirErrorClosesTheLedger) {
  for (const TimeScheme scheme : {TimeScheme::kSdirk2, TimeScheme::kAuto}) {
    Ledger ledger;
    EXPECT_LT(std::abs(fall_error(scheme, 0.04, &ledger)), 2e-3) << int(scheme);
    EXPECT_LT(ledger.linear_gap, 1e-9);
    const double lost = ledger.sum.start.energy.total() - ledger.sum.end.energy.total();
    EXPECT_NEAR(-ledger.sum.done.loaded / lost, 1, 0.01);
  }
}

TEST(Wind, BearsOnPinsInFullHoweverLightTheBody) {
  // k D/m is 0.03 and 30 at the first step
  for (const double density : {100.0, 0.1})
    for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2}) {
      Scene scene = strip_in_wind(density, 8);
      scene.scheme = scheme;
      scene.dt = 0.05;
      scene.materials[0].loss_factor = 0.5;
      Solver solver(scene, {.tolerance = 1e-3});
      State state = initial_state(scene);
      StepReport report;
      for (int k = 0; k < 40; ++k) {
        report = solver.step(state);
        EXPECT_TRUE(report.converged) << density << ' ' << int(scheme) << ' ' << report.residual;
      }
      // at rest, but for what the strip has turned and still swings
      const double pressure = kAir / 2 * 64 * 0.6 * 0.2;
      EXPECT_NEAR(report.reactions.at(0).force[1] / pressure, -1, 0.02) << density << int(scheme);
    }
}

}  // namespace
}  // namespace elastogen::test
