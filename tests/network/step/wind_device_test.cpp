// SPDX-License-Identifier: Apache-2.0
// Loads that change, and wind, on the device against the CPU. Nothing is here in builds without CUDA;
// skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "tests/network/device_support.hpp"
#include "tests/network/moved_scenes.hpp"
#include "tests/network/wind_scenes.hpp"

namespace elastogen::test {
namespace {

using WindOnCard = OnCard;

TEST_F(WindOnCard, StepsOfAllSchemesAndSolversAreThoseOfTheHost) {
  for (const TimeScheme scheme : kMovedSchemes)
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
      SCOPED_TRACE(concat(scheme_name(scheme), ", ", solver_name(mode)));
      const Scene scene = strip_in_gusts(scheme);
      const MovedRun a = run_moved(scene, mode, Device::kCpu, 11),
                     b = run_moved(scene, mode, Device::kCuda, 11);
      EXPECT_EQ(b.state.time, a.state.time);
      EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-6);
      EXPECT_LT(relative_difference(b.state.v, a.state.v), 1e-5);
      EXPECT_NEAR(b.loaded, a.loaded, 1e-4 * std::abs(a.loaded));
      ASSERT_EQ(b.reactions.size(), a.reactions.size());
      for (size_t h = 0; h < a.reactions.size(); ++h)
        EXPECT_LT(safe_norm(minus(b.reactions[h].force, a.reactions[h].force)),
                  1e-4 * safe_norm(a.reactions[h].force));
    }
}

TEST_F(WindOnCard, LoadsAreHandedOutAsByTheHost) {
  for (const TimeScheme scheme : {TimeScheme::kBdf2, TimeScheme::kSdirk2}) {
    const Scene scene = strip_in_gusts(scheme);
    Solver host(scene, {.mode = SolverMode::kNewton, .device = Device::kCpu, .tolerance = 1e-6}),
        card(scene, {.mode = SolverMode::kNewton, .device = Device::kCuda, .tolerance = 1e-6});
    host.begin(initial_state(scene)), card.begin(initial_state(scene));
    for (int k = 0; k < 5; ++k) host.advance(), card.advance();
    const StageData a = host.stage_data(), b = card.stage_data();
    for (const auto& [x, y] : {std::pair(a.load, b.load), {a.first_load, b.first_load}}) {
      ASSERT_EQ(x.size(), y.size());
      EXPECT_EQ(x.size() > 0, x.data == a.load.data || has_stages(scheme));
      double most = 0, off = 0;
      for (int64_t i = 0; i < x.size(); ++i) {
        most = std::max(most, std::abs(x.data[i]));
        off = std::max(off, std::abs(x.data[i] - y.data[i]));
      }
      EXPECT_LE(off, 1e-4 * most);
    }
  }
}

TEST_F(WindOnCard, APlateFallsWithoutAPinAsOnTheHost) {
  for (const TimeScheme scheme : kMovedSchemes) {
    Scene scene = box_in_wind({-0.3, 0, -0.3}, {0.3, 0.1, 0.3}, 0.1, {});
    scene.gravity = {0, -9.81, 0};
    scene.scheme = scheme;
    finish_scene(scene);
    const MovedRun a = run_moved(scene, SolverMode::kNewton, Device::kCpu, 11),
                   b = run_moved(scene, SolverMode::kNewton, Device::kCuda, 11);
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-6) << scheme_name(scheme);
    EXPECT_NEAR(b.loaded, a.loaded, 1e-5 * std::abs(a.loaded)) << scheme_name(scheme);
  }
}

TEST_F(WindOnCard, RunsRepeatToTheBit) {
  for (const TimeScheme scheme : {TimeScheme::kBdf2, TimeScheme::kAuto}) {
    const Scene scene = strip_in_gusts(scheme);
    const MovedRun a = run_moved(scene, SolverMode::kQuasi, Device::kCuda, 8),
                   b = run_moved(scene, SolverMode::kQuasi, Device::kCuda, 8);
    EXPECT_EQ(a.state.x, b.state.x);
    EXPECT_EQ(a.state.v, b.state.v);
  }
}

TEST_F(WindOnCard, AutoTakesTheCardToo) {
  const Scene scene = strip_in_gusts(TimeScheme::kAuto);
  EXPECT_NE(Solver(scene, {.device = Device::kAuto}).device(), "cpu");
}

}  // namespace
}  // namespace elastogen::test

#endif
