// SPDX-License-Identifier: Apache-2.0
// Wind on finite elements: the fall of a plate through air, and the network's steps.
#include "tests/mpm_fem/stage_scenes.hpp"
#include "tests/network/wind_scenes.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <tuple>

namespace elastogen::test {
namespace {

using fem::FemScene;
using fem::FemState;
using fem::FemStepReport;
using fem::Scheme;

/// The steps of a scene by the integrator of its scheme, each of which must converge.
void run_fem(const FemScene& scene, double tolerance, FemState& state, double end) {
  const bool stages = scene.scheme == Scheme::kSdirk2 || scene.scheme == Scheme::kAuto;
  const fem::ImplicitOptions options{.tolerance = tolerance, .as_positions = true};
  std::optional<fem::ImplicitFem> one;
  std::optional<fem::StageFem> two;
  if (stages)
    two.emplace(scene, fem::StageOptions{.solve = options, .follows_time_error = false});
  else
    one.emplace(scene, options);
  while (state.time < end - 1e-9) {
    const FemStepReport report = stages ? two->step(state) : one->step(state);
    ASSERT_TRUE(report.converged) << report.residual;
  }
}

/// How far a plate of 3 kg a square metre is off where it should be after falling for 1.6 s [of the way].
double fall_error(Scheme scheme, fem::Element element, double dt) {
  Scene grid = box_in_wind({-0.3, 0, -0.3}, {0.3, 0.1, 0.3}, 0.1, {});
  grid.gravity = {0, -9.81, 0};
  grid.dt = dt;
  finish_scene(grid);
  FemScene scene = as_fem(grid, element);
  scene.scheme = scheme;
  scene.in_wind = &grid;
  FemState state = fem::rest_state(scene);
  run_fem(scene, 1e-8, state, 1.6);
  const double steady = std::sqrt(2 * 3.0 * 9.81 / 1.2);
  const double fall = steady * steady / 9.81 * std::log(std::cosh(9.81 * 1.6 / steady));
  double mean = 0, mass = 0;
  for (int64_t n = 0; n < state.u.rows(); ++n) {
    mean -= grid.mass(n) * state.u(n, 1);
    mass += grid.mass(n);
  }
  return mean / mass / fall - 1;
}

TEST(WindOnElements, APlateFallsAsItsDragSaysToTheOrderOfTheScheme) {
  using E = fem::Element;
  for (const auto& [scheme, element, order, most] :
       {std::tuple(Scheme::kEuler, E::kHex, 1.0, 0.02),
        std::tuple(Scheme::kBdf2, E::kVoxel, 2.0, 2e-3),
        std::tuple(Scheme::kNewmark, E::kHexBbar, 2.0, 5e-4),
        std::tuple(Scheme::kSdirk2, E::kHex, 2.0, 5e-4)}) {
    const double coarse = fall_error(scheme, element, 0.08),
                 fine = fall_error(scheme, element, 0.04);
    EXPECT_LT(std::abs(fine), most) << int(scheme);
    EXPECT_NEAR(std::log2(std::abs(coarse / fine)), order, 0.25) << int(scheme);
  }
}

/// Displacements of the network after 10 steps of an equal length.
Array<double> network_steps(const Scene& scene) {
  Solver solver(
      scene,
      {.mode = SolverMode::kNewton, .tolerance = 1e-9, .follows_time_error = false, .skip = false});
  State state = initial_state(scene);
  while (state.time < 10 * scene.dt - 1e-9) EXPECT_TRUE(solver.step(state).converged);
  for (int64_t k = 0; k < state.x.size(); ++k) state.x.data()[k] -= scene.grid.rest.data()[k];
  return state.x;
}

TEST(WindOnElements, MovesTheVoxelElementAsItDoesTheNetwork) {
  for (const auto& [of_network, scheme] : {std::pair(TimeScheme::kEuler, Scheme::kEuler),
                                           {TimeScheme::kBdf2, Scheme::kBdf2},
                                           {TimeScheme::kSdirk2, Scheme::kSdirk2},
                                           {TimeScheme::kAuto, Scheme::kAuto}}) {
    Scene grid = strip_in_wind(20, 8);
    grid.scheme = of_network;
    grid.wind.velocity = {{0, {2, 5, 0}}, {0.2, {0, 12, 3}}};
    finish_scene(grid);
    FemScene scene = as_fem(grid);
    scene.scheme = scheme;
    scene.in_wind = &grid;
    FemState state = fem::rest_state(scene);
    run_fem(scene, 1e-9, state, 10 * grid.dt);
    const Array<double> u = network_steps(grid);
    double most = 0, off = 0;
    for (int64_t k = 0; k < u.size(); ++k) {
      most = std::max(most, std::abs(u.data()[k]));
      off = std::max(off, std::abs(u.data()[k] - state.u.data()[k]));
    }
    EXPECT_GT(most, 0.01);
    EXPECT_LT(off, 1e-6 * most) << int(scheme);
  }
}

}  // namespace
}  // namespace elastogen::test
