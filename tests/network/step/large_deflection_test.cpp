// SPDX-License-Identifier: Apache-2.0
// Static bending far beyond small rotations, through the solver: steps of implicit Euler so long
// that inertia vanishes, against the elastica.
#include "core/time_scheme.hpp"
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr double kBeamYoung = 1e7, kDensity = 1000;

/// Bending stiffness of a square section.
double rigidity(double thickness) {
  return kBeamYoung * std::pow(thickness, 4) / 12;
}

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

/// A clamped beam of length 1, n voxels thick, at nu = 0; not finished.
Scene slender_beam(int n, int slenderness) {
  const double h = 1.0 / (slenderness * n);
  Scene scene = scene_on(make_box(slenderness * n, n, n, h), solid(kBeamYoung, 0));
  pin_below(scene, 0, h / 2);
  scene.dt = 100;  // some hundred periods
  return scene;
}

/// Brings the state to rest under a gravity that grows from the present one in two steps.
void settle(Scene& scene, Solver& solver, State& state, double gravity) {
  const double before = -scene.gravity[1];
  for (const double share : {0.5, 1.0}) {
    scene.gravity[1] = -before - share * (gravity - before);
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.converged) << gravity << " residual " << report.residual;
    state.v.fill(0);
  }
}

/// Deflection of the tip under its own weight w = K EI / L^3.
double tip_deflection(Scene& scene, Solver& solver, State& state, double K, double thickness) {
  settle(scene, solver, state, K * rigidity(thickness) / (kDensity * thickness * thickness));
  const int last = scene.grid.node_coord(scene.grid.node_count() - 1, 0);
  return thickness / 2 - plane_centre(scene, state, last)[1];
}

TEST(LargeDeflection, ABeamUnderItsOwnWeightBendsAsTheElastica) {
  // deflection of the tip over L at K = w L^3 / EI: elastica, and the same with the shear and the
  // stretch of a section (Reissner's beam, shear factor 5/6) at L/t = 10 and 20, by shooting
  const struct {
    double K, elastica, thick, slender;
  } rows[] = {{0.5, 0.06231, 0.06280, 0.06243}, {1, 0.12347, 0.12446, 0.12372},
              {2, 0.23851, 0.24039, 0.23898},   {5, 0.49591, 0.49986, 0.49689},
              {10, 0.70020, 0.70675, 0.70184},  {20, 0.82988, 0.84145, 0.83277},
              {50, 0.90792, 0.93411, 0.91445}};
  for (const auto& [n, slenderness] : {std::pair{4, 10}, {8, 10}, {4, 20}}) {
    Scene scene = slender_beam(n, slenderness);
    finish_scene(scene);
    Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-4});
    State state = initial_state(scene);
    for (const auto& row : rows) {
      const double tip = tip_deflection(scene, solver, state, row.K, 1.0 / slenderness);
      const double reissner = slenderness == 10 ? row.thick : row.slender;
      printf("L/t %d, n %d, K %4.1f: %.5f, elastica %.5f (%+.2f %%), Reissner %.5f (%+.2f %%)\n",
             slenderness, n, row.K, tip, row.elastica, 100 * (tip / row.elastica - 1), reissner,
             100 * (tip / reissner - 1));
      // the axis of the thick one stretches by 2 % at 50, which the elastica leaves out
      if (slenderness > 10 || row.K < 50) {
        EXPECT_NEAR(tip / row.elastica, 1, 0.02) << row.K;
      }
      EXPECT_NEAR(tip / reissner, 1, 0.01) << row.K;
    }
  }
}

TEST(LargeDeflection, ABeamWithALoadAtItsTipBendsAsTheElastica) {
  // the weight of a heavy last layer, which acts at its middle, one unit from the clamp; deflection
  // and place of the loaded section over that length at P L^2 / EI, as above
  const struct {
    double load, down, along, reissner;
  } rows[] = {{0.25, 0.08275, 0.99588, 0.08324}, {0.5, 0.16214, 0.98408, 0.16311},
              {1, 0.30172, 0.94357, 0.30349},    {2, 0.49346, 0.83936, 0.49642},
              {3, 0.60325, 0.74558, 0.60720},    {5, 0.71379, 0.61237, 0.71966},
              {10, 0.81061, 0.44500, 0.82129}};
  constexpr int kThick = 4;
  constexpr double kH = 0.1 / kThick, kLength = 1 - kH / 2;
  Scene scene = slender_beam(kThick, 10);
  scene.materials[0].density = 1e-3;
  scene.materials.push_back(solid(kBeamYoung, 0));
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    scene.material(v) = scene.grid.voxel_coord(v, 0) == 10 * kThick - 1;
  finish_scene(scene);
  Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-4});
  State state = initial_state(scene);
  for (const auto& row : rows) {
    const double force = row.load * rigidity(0.1) / (kLength * kLength);
    settle(scene, solver, state, force / (kDensity * 0.01 * kH));
    const Vec3 inner = plane_centre(scene, state, 10 * kThick - 1);
    const Vec3 outer = plane_centre(scene, state, 10 * kThick);
    const double down = (0.05 - (inner[1] + outer[1]) / 2) / kLength;
    const double along = (inner[0] + outer[0]) / 2 / kLength;
    printf(
        "load %5.2f: %.5f, elastica %.5f (%+.2f %%), Reissner %.5f (%+.2f %%); place %.5f, "
        "elastica "
        "%.5f (%+.2f %%)\n",
        row.load, down, row.down, 100 * (down / row.down - 1), row.reissner,
        100 * (down / row.reissner - 1), along, row.along, 100 * (along / row.along - 1));
    EXPECT_NEAR(down / row.down, 1, 0.02) << row.load;
    EXPECT_NEAR(down / row.reissner, 1, 0.01) << row.load;
    EXPECT_NEAR(along / row.along, 1, 0.02) << row.load;
  }
}

}  // namespace
}  // namespace elastogen::test
