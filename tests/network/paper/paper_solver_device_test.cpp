// SPDX-License-Identifier: Apache-2.0
// The published algorithm on the device against the CPU's. Nothing is here in builds without CUDA;
// skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "network/paper/paper_solver_device.hpp"

#include "core/error.hpp"
#include "network/paper/paper_solver.hpp"
#include "network/solver.hpp"
#include "tests/network/device_support.hpp"

namespace elastogen::test {
namespace {

/// Full and border voxels, two materials; the loops take no torsion correction.
std::vector<Scene> paper_scenes() {
  std::vector<Scene> list;
  for (const Hourglass hourglass : {Hourglass::kVariance, Hourglass::kOff})
    for (const auto& make : {beam_of_regions, falling_bar, three_blocks}) {
      list.push_back(make(TimeScheme::kEuler));
      list.back().hourglass = hourglass;
      finish_scene(list.back());
    }
  return list;
}

/// A step from a state in motion by the loops of the host and by those of the device.
struct Ends {
  Ends(const Scene& scene, const PaperLoops& loops, bool float64) {
    State state = initial_state(scene, {.velocity = {0.3, -0.2, 0.5}, .spin = {2, -1, 3}});
    const std::vector<double> shake = random_field(scene, 0.05 * scene.grid.h, 4);
    for (int64_t k = 0; k < state.x.size(); ++k) state.x.data()[k] += shake[size_t(k)];
    const auto never = [] { return false; };
    IncrementalPotential potential(scene);
    potential.begin_step(state, step_scheme(scene, state));
    host.resize(potential.predictor().size());
    device.resize(host.size());
    PaperSolver(potential, loops).solve(host.data(), never);
    cuda::DeviceQuasi quasi(potential);
    quasi.begin_step(potential);
    cuda::DevicePaper paper(quasi, loops, float64);
    const IterationResult result = paper.solve(never);
    EXPECT_EQ(result.outer, loops.outer);
    EXPECT_EQ(result.inner, loops.outer * loops.inner);
    quasi.download_u(device.data());
  }
  std::vector<double> host, device;
};

TEST_F(OnCard, PaperLoopsEndWhereThoseOfTheHostEnd) {
  for (const Scene& scene : paper_scenes())
    for (const int modes : {0, 27}) {  // 9 cosines: more than one batch of products
      SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, hourglass ", int(scene.hourglass),
                          ", modes ", modes));
      // the reduced matrix multiplies rounding by its condition
      const Ends precise(scene, {3, 4, modes}, true);
      EXPECT_LT(relative_difference(precise.device, precise.host), modes == 0 ? 1e-12 : 1e-10);
      if (scene.hourglass == Hourglass::kOff) continue;  // sweeps that diverge multiply rounding
      const Ends single(scene, {3, 4, modes}, false);
      EXPECT_LT(relative_difference(single.device, single.host), 1e-5);
    }
}

TEST_F(OnCard, PaperModeRunsThere) {
  Scene scene = beam_of_regions(TimeScheme::kEuler);
  scene.hourglass = Hourglass::kVariance;
  finish_scene(scene);
  SolverOptions options{.mode = SolverMode::kPaper};
  Solver on_host(scene, options);
  options.device = Device::kCuda;
  Solver on_device(scene, options), again(scene, options);
  EXPECT_NE(on_device.device(), "cpu");
  State host = initial_state(scene), device = host, repeated = host;
  for (int k = 0; k < 20; ++k) {
    const StepReport a = on_host.step(host), b = on_device.step(device);
    again.step(repeated);
    EXPECT_NEAR(b.residual, a.residual, 1e-3 * a.residual);
    EXPECT_EQ(b.inner, a.inner);
    EXPECT_FALSE(b.float64);
  }
  EXPECT_LT(distance_of_ways(scene, device, host), 1e-5);
  EXPECT_EQ(device.x, repeated.x);  // the same bits
  scene.hourglass = Hourglass::kFull;
  EXPECT_THROW(Solver(scene, options), Error);
}

}  // namespace
}  // namespace elastogen::test

#endif
