// SPDX-License-Identifier: Apache-2.0
// Static bending far beyond small rotations, through the solver: steps of implicit Euler so long
// that inertia vanishes, against the elastica.
#include "core/time_scheme.hpp"
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr int kThick = 8;                // voxels through the thickness
constexpr double kH = 0.1 / kThick;      // L = 1, section 0.1 x 0.1
constexpr double kRigidity = 1e-4 / 12;  // I: EI = E kRigidity

/// Mean position of the nodes of the plane at lattice place x.
Vec3 plane_centre(const Scene& scene, const State& state, int place) {
  Vec3 sum = {};
  double weight = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    if (scene.grid.node_coord(n, 0) != place) continue;
    int share = 0;
    for (int c = 0; c < 8; ++c) share += scene.grid.voxels(n, c) >= 0;
    for (int i = 0; i < 3; ++i) sum[size_t(i)] += share * state.x(n, i);
    weight += share;
  }
  for (double& value : sum) value /= weight;
  return sum;
}

/// Moves the state to rest under the scene's gravity; the load grows from that of the state.
void settle(Solver& solver, State& state) {
  StepReport report = solver.step(state);
  EXPECT_TRUE(report.converged) << report.residual;
  printf("  [%d/%d %.0f ms]", report.outer, report.inner, report.ms);
  state.v.fill(0);
}

Scene beam(double young, Law law) {
  Scene scene = scene_on(make_box(10 * kThick, kThick, kThick, kH), solid(young, 0, law));
  pin_below(scene, 0, kH / 2);
  scene.dt = 100;  // some hundred periods
  finish_scene(scene);
  return scene;
}

TEST(LargeDeflection, ABeamUnderItsOwnWeightBendsAsTheElastica) {
  // K = w L^3 / EI and the deflection of the tip over L
  const std::pair<double, double> table[] = {{0.5, 0.06231}, {1, 0.12347},  {2, 0.23851},
                                             {5, 0.49591},   {10, 0.70020}, {20, 0.82988},
                                             {50, 0.90792}};
  const double young = 1e7;
  for (const Law law : {Law::kNeoHookean, Law::kFixedCorotated}) {
    Scene scene = beam(young, law);
    Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-4});
    State state = initial_state(scene);
    double before = 0;
    for (const auto& [K, deflection] : table) {
      // w = rho g A
      for (const double share : {0.5, 1.0}) {
        const double load = before + share * (K - before);
        scene.gravity = {0, -load * young * kRigidity / (1000 * 0.01), 0};
        settle(solver, state);
      }
      before = K;
      const double measured = 0.05 - plane_centre(scene, state, 10 * kThick)[1];
      const double error = measured / deflection - 1;
      printf("K %5.1f: deflection %.5f L, elastica %.5f, %+.2f %%\n", K, measured, deflection,
             100 * error);
      EXPECT_LT(std::abs(error), 0.02) << K;
    }
  }
}

}  // namespace
}  // namespace elastogen::test
