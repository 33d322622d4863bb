// SPDX-License-Identifier: Apache-2.0
// Scenes beside each other on one device, a thread each, as `animate --batch --jobs` runs them.
// Nothing is here in builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/solver.hpp"
#include "tests/network/device_support.hpp"

#include <thread>

namespace elastogen::test {
namespace {

class ThreadsOnCard : public OnCard {};

Array<double> positions_of_clip(const Scene& scene) {
  constexpr int kSteps = 8;
  Solver solver(scene, {.mode = SolverMode::kAuto, .device = Device::kCuda});
  State state = initial_state(scene);
  solver.begin(state);
  for (int k = 0; k < kSteps; ++k) solver.advance();
  solver.read(state);
  return std::move(state.x);
}

TEST_F(ThreadsOnCard, ScenesBesideEachOtherEndInTheBitsOfOneAlone) {
  // of different sizes, one after another in each thread, so that a scene gets memory that others
  // have had while still others go on
  constexpr int kThreads = 4, kScenes = 24;
  std::vector<Scene> scenes;
  for (int k = 0; k < kScenes; ++k) {
    const int side = 18 + 5 * (k % 3);
    scenes.push_back(clamped_beam(side, side, side, 0.5 / side, solid(2e4 + 1e3 * k, 0.4)));
    scenes.back().gravity = {0, -9.81, 0};
    finish_scene(scenes.back());
  }
  std::vector<Array<double>> alone(kScenes), beside(kScenes);
  for (size_t k = 0; k < kScenes; ++k) alone[k] = positions_of_clip(scenes[k]);
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      for (size_t k = size_t(t); k < kScenes; k += kThreads)
        beside[k] = positions_of_clip(scenes[k]);
    });
  for (std::thread& thread : threads) thread.join();
  for (size_t k = 0; k < kScenes; ++k) EXPECT_EQ(beside[k], alone[k]) << "scene " << k;
}

}  // namespace
}  // namespace elastogen::test

#endif
