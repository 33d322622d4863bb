// SPDX-License-Identifier: Apache-2.0
// Steps of bodies with ends that move, or under loads, on the CPU.
#include "core/error.hpp"
#include "tests/network/moved_scenes.hpp"

namespace elastogen::test {
namespace {

TEST(MovedBodies, EndsAreWhereHoldersPutThem) {
  for (const TimeScheme scheme : kMovedSchemes)
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
      for (const bool cut : {false, true})
        for (const Scene& scene : {pulled_bar(scheme, cut), twisted_bar(scheme, cut)}) {
          SCOPED_TRACE(concat(scheme_name(scheme), ", cut ", cut));
          expect_held(scene, run_moved(scene, mode, Device::kCpu, 6).state);
        }
}

TEST(MovedBodies, AFreeBodyUnderALoadTakesUpItsImpulse) {
  for (const TimeScheme scheme : kMovedSchemes) {
    SCOPED_TRACE(scheme_name(scheme));
    Scene scene = scene_on(make_box(8, 3, 3, 0.05), solid(2e5, 0.3));
    scene.gravity = {0, -9.81, 0};
    scene.scheme = scheme;
    finish_scene(scene);
    add_load(scene);
    const MovedRun run = run_moved(scene, SolverMode::kNewton, Device::kCpu, 6);
    const Vec3 gained = total_momentum(scene, run.state), force = force_on(scene);
    for (size_t d = 0; d < 3; ++d)
      EXPECT_NEAR(gained[d], run.state.time * force[d], 1e-12 * safe_norm(force));
  }
}

}  // namespace
}  // namespace elastogen::test
