// SPDX-License-Identifier: Apache-2.0
// Bodies held at borders that cut voxels, against the tables of a reference: a bar 1 x 0.2 x 0.2 m with
// a hundredth of its length held at both ends, E 1, nu 0.3 and weight 1 a volume, by bricks of 27 nodes.
#include "tests/network/held_scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr double kBarEdge = 0.05;               // of a voxel: four across the bar
constexpr double kSagUnit = 1000 * 9.81 / 1e8;  // of displacements, for those of weight 1 and E 1
constexpr double kQuarter = -0.64436, kMiddle = -1.0588;  // sag of the reference

const std::vector<Border> kBothEnds = {half_space_border(true, 0.01),
                                       half_space_border(false, 0.99)};

/// The bar, its border at the left an offset [voxels] behind a layer of nodes.
Scene held_bar(double offset, double dt = 100) {
  return held_scene(box_surface({0, 0, 0}, {1, 0.2, 0.2}), kBothEnds, kBarEdge,
                    {0.01 - offset * kBarEdge, 0.02, 0.02}, dt);
}

TEST(HeldBar, SagsAlikeOnAnyGridAndAtBothEnds) {
  double least = 1e300, most = 0;
  for (const double offset : {0.0, 1e-4, 0.1, 0.3, 0.5, 0.7, 0.9, 0.9999}) {
    const Scene scene = held_bar(offset);
    const State state = equilibrium(scene);
    const Array<double> u = displacements(scene, state,
                                          {{0.25, 0.1, 0.1},
                                           {0.5, 0.1, 0.1},
                                           {0.75, 0.1, 0.1},
                                           {0.01, 0.05, 0.13},
                                           {0.99, 0.19, 0.01}});
    const double sag = u(1, 1) / kSagUnit;
    EXPECT_NEAR(sag / kMiddle, 1 - 0.0348, 0.01) << offset;  // the error of a grid that fits
    EXPECT_NEAR(u(0, 1) / kSagUnit / kQuarter, 1 - 0.0348, 0.01) << offset;
    EXPECT_LT(std::abs(u(0, 1) - u(2, 1)), 0.005 * std::abs(u(1, 1))) << offset;
    for (int p = 3; p < 5; ++p)
      for (int d = 0; d < 3; ++d) EXPECT_LT(std::abs(u(p, d)), 1e-6 * std::abs(u(1, 1)));
    least = std::min(least, -sag);
    most = std::max(most, -sag);
  }
  EXPECT_LT(most, 1.015 * least);
}

TEST(HeldStrip, ThinnerThanAVoxelBendsAlikeOnAnyGrid) {
  double least = 1e300, most = 0;
  for (const double offset : {0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.91, 0.95, 0.99}) {
    const Scene scene =
        held_scene(box_surface({0, 0, 0}, {0.5, 0.02, 0.2}), {half_space_border(true, 0.01)},
                   kBarEdge, {0.01 - offset * kBarEdge, 0, 0});
    const double tip = -displacements(scene, equilibrium(scene), {{0.49, 0.01, 0.1}})(0, 1);
    least = std::min(least, tip);
    most = std::max(most, tip);
  }
  EXPECT_GT(least, 5e-3);
  EXPECT_LT(most, 1.015 * least);
}

/// The scene of the bar seen in a mirror.
Scene mirrored_bar(double offset, double dt) {
  return held_scene(box_surface({0, 0, 0}, {1, 0.2, 0.2}), kBothEnds, kBarEdge,
                    {0.99 + offset * kBarEdge, 0.02, 0.02}, dt);
}

/// Displacements of some points after 20 steps, seen in a mirror or not.
Array<double> swung(Scene scene, TimeScheme scheme, SolverMode mode, bool mirror) {
  scene.scheme = scheme;
  scene.materials[0] = solid(2e5, 0.3);
  finish_scene(scene);
  SolverOptions options;
  options.mode = mode;
  options.tolerance = 1e-6;
  options.follows_time_error = false;
  Solver solver(scene, options);
  State state = initial_state(scene);
  while (state.time < 20 * scene.dt * (1 - 1e-9)) {
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.converged) << report.residual;
    if (!report.converged) break;
  }
  // the state meets the constraints, to the rounding of positions
  Array<double> u(state.x.rows(), 3);
  for (int64_t k = 0; k < u.size(); ++k)
    u.data()[k] = state.x.data()[k] - scene.grid.rest.data()[k];
  Array<double> followed = u, v = state.v;
  scene.dependent.fill(followed.data());
  scene.dependent.fill(v.data());
  double off_x = 0, off_v = 0, speed = 0;
  for (int64_t k = 0; k < u.size(); ++k) {
    off_x = std::max(off_x, std::abs(followed.data()[k] - u.data()[k]));
    off_v = std::max(off_v, std::abs(v.data()[k] - state.v.data()[k]));
    speed = std::max(speed, std::abs(v.data()[k]));
  }
  EXPECT_LT(off_x, 1e-15);
  EXPECT_LT(off_v, 1e-12 * speed);
  std::vector<Vec3> points;
  for (const double x : {0.1, 0.25, 0.4, 0.7, 0.9, 0.99})
    points.push_back({mirror ? 1 - x : x, 0.07, 0.12});
  return displacements(scene, state, points);
}

TEST(HeldBar, SwingsAsItsMirrorImageDoes) {
  for (const TimeScheme scheme :
       {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2, TimeScheme::kAuto})
    for (const SolverMode mode : {SolverMode::kNewton, SolverMode::kQuasi}) {
      const Array<double> a = swung(held_bar(0.7, 1.0 / 60), scheme, mode, false),
                          b = swung(mirrored_bar(0.7, 1.0 / 60), scheme, mode, true);
      double most = 0;
      for (int p = 0; p < 6; ++p)
        for (int d = 0; d < 3; ++d) most = std::max(most, std::abs(a(p, d)));
      EXPECT_GT(most, 1e-3);
      for (int p = 0; p < 6; ++p)
        for (int d = 0; d < 3; ++d)
          EXPECT_NEAR(a(p, d), (d == 0 ? -1 : 1) * b(p, d), 1e-4 * most)
              << int(scheme) << ' ' << int(mode);
      for (int d = 0; d < 3; ++d) EXPECT_LT(std::abs(a(5, d)), 1e-12);  // the held face
    }
}

TEST(HeldBlock, OnABallIsThatOfAFineGrid) {
  const Surface block = box_surface({0, 0, 0}, {0.6, 0.6, 0.6});
  const std::vector<Border> ball = {ball_border({0.3, 0.3, 0.3}, 0.17)};
  const std::vector<Vec3> probes = {{0.02, 0.3, 0.3}, {0.58, 0.3, 0.3},   {0.3, 0.02, 0.3},
                                    {0.3, 0.58, 0.3}, {0.02, 0.02, 0.02}, {0.58, 0.58, 0.02}};
  const Scene fine = held_scene(block, ball, 0.02, {0.01, 0.01, 0.01});
  const Array<double> exact = displacements(fine, equilibrium(fine), probes);
  double most = 0;
  for (int64_t k = 0; k < exact.size(); ++k) most = std::max(most, std::abs(exact.data()[k]));
  for (const double offset : {0.0, 0.3, 0.5}) {
    const Scene scene = held_scene(block, ball, 0.04,
                                   {0.04 * offset, 0.02 + 0.04 * offset, 0.04 * offset * offset});
    const Array<double> u = displacements(scene, equilibrium(scene), probes);
    double off = 0;
    for (int64_t k = 0; k < u.size(); ++k)
      off = std::max(off, std::abs(u.data()[k] - exact.data()[k]));
    printf("ball of 4.25 voxels, offset %.1f: %.2f %% of the largest displacement\n", offset,
           100 * off / most);
    EXPECT_LT(off, 0.025 * most);
  }
}

TEST(HeldBar, HasTheDifferencesOfItsPotentialAsGradient) {
  const Scene scene = held_bar(0.7);
  IncrementalPotential potential(scene);
  potential.begin_step(initial_state(scene), {TimeScheme::kEuler, 0.01, 1});
  std::vector<double> u = random_field(scene, 1e-3, 5), p = random_field(scene, 1, 6), g(u.size()),
                      ends(u.size());
  scene.dependent.fill(u.data());
  scene.dependent.fill(p.data());
  potential.evaluate(u.data(), g.data());
  double slope = 0, values[2];
  for (size_t k = 0; k < u.size(); ++k) slope += g[k] * p[k];
  for (const int side : {0, 1}) {
    for (size_t k = 0; k < u.size(); ++k) ends[k] = u[k] + (side ? 1e-6 : -1e-6) * p[k];
    values[side] = potential.evaluate(ends.data(), static_cast<double*>(nullptr)).total();
  }
  EXPECT_NEAR((values[1] - values[0]) / 2e-6, slope, 1e-6 * std::abs(slope));
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    for (int d = 0; d < 3; ++d) EXPECT_EQ(g[size_t(3 * scene.dependent.node(i) + d)], 0);
}

}  // namespace
}  // namespace elastogen::test
