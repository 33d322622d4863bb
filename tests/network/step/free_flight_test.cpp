// SPDX-License-Identifier: Apache-2.0
#include "network/step/free_flight.hpp"

#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen::test {
namespace {

/// Three blocks of 2x1x1 voxels side by side, the middle one pinned at a node.
Scene three_pieces() {
  std::vector<std::array<int32_t, 3>> coords;
  for (int piece = 0; piece < 3; ++piece)
    for (int x = 0; x < 2; ++x) coords.push_back({x, 4 * piece, 0});
  Array<int32_t> list(int64_t(coords.size()), 3);
  for (size_t v = 0; v < coords.size(); ++v)
    std::copy(coords[v].begin(), coords[v].end(), list.row(int64_t(v)));
  Scene scene = scene_on(make_grid(list, 0.1, {}), solid(2e4, 0.3));
  scene.gravity = {0, -9.81, 0};
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    if (scene.grid.node_coord(n, 1) == 4 && scene.grid.node_coord(n, 0) == 0) scene.pinned(n) = 1;
  finish_scene(scene);
  return scene;
}

Vec3 weighted_sum(const Scene& scene, const double* values, int piece) {
  Vec3 sum = {};
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    for (size_t d = 0; scene.grid.piece(n) == piece && d < 3; ++d)
      sum[d] += scene.mass(n) * values[3 * size_t(n) + d];
  return sum;
}

TEST(FreeFlight, ShiftsEachPieceThatNothingHoldsToTheMeanThatIsAskedFor) {
  const Scene scene = three_pieces();
  FreeFlight flight(scene);
  ASSERT_TRUE(flight.exists());
  std::vector<double> values(3 * size_t(scene.grid.node_count())), aim(values.size());
  for (size_t k = 0; k < values.size(); ++k)
    values[k] = std::sin(double(k)), aim[k] = std::cos(double(k * k));
  const std::vector<double> before = values;
  flight.match_means(values.data(), [&](size_t n, size_t d) { return aim[3 * n + d]; });
  for (int piece = 0; piece < 3; ++piece) {
    const Vec3 now = weighted_sum(scene, values.data(), piece);
    const Vec3 asked = weighted_sum(scene, piece == 1 ? before.data() : aim.data(), piece);
    for (size_t d = 0; d < 3; ++d) EXPECT_NEAR(now[d], asked[d], 1e-14);
  }
  // by one vector a piece, which leaves strains as they are
  for (size_t n = 1; n < values.size() / 3; ++n)
    for (size_t d = 0; d < 3 && scene.grid.piece(int64_t(n)) == scene.grid.piece(0); ++d)
      EXPECT_NEAR(values[3 * n + d] - values[d], before[3 * n + d] - before[d], 1e-15);
}

TEST(FreeFlight, IsNotThereWhereAllPiecesAreHeld) {
  Scene scene = three_pieces();
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    if (scene.grid.node_coord(n, 0) == 0) scene.pinned(n) = 1;
  EXPECT_FALSE(FreeFlight(scene).exists());
}

TEST(FreeFlight, PiecesFallAsOneMassPointWhateverTheTolerance) {
  const Scene scene = three_pieces();
  Solver solver(scene, {.mode = SolverMode::kQuasi, .tolerance = 0.1});
  State state = initial_state(scene, {.spin = {3, 4, 5}});
  const Vec3 x0 = weighted_sum(scene, state.x.data(), 0),
             v0 = weighted_sum(scene, state.v.data(), 0);
  const int steps = 50;
  for (int k = 0; k < steps; ++k) ASSERT_TRUE(solver.step(state).converged);
  double mass = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    if (scene.grid.piece(n) == 0) mass += scene.mass(n);
  const double t = steps * scene.dt;
  const Vec3 x = weighted_sum(scene, state.x.data(), 0), v = weighted_sum(scene, state.v.data(), 0);
  for (size_t d = 0; d < 3; ++d) {
    // implicit Euler: v0 t + g t (t + dt)/2
    const double way = t * v0[d] + mass * scene.gravity[d] * t * (t + scene.dt) / 2;
    EXPECT_NEAR(x[d] - x0[d], way, 1e-12 * mass);
    EXPECT_NEAR(v[d] - v0[d], mass * scene.gravity[d] * t, 1e-12 * mass);
  }
}

}  // namespace
}  // namespace elastogen::test
