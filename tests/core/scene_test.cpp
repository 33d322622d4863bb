// SPDX-License-Identifier: Apache-2.0
#include "core/scene.hpp"

#include "core/error.hpp"
#include "core/state.hpp"
#include "tests/support/element_assembly.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace elastogen {
namespace {

Material scene_solid(double young, double poisson, double density) {
  return {"test", Law::kNeoHookean, young, poisson, density};
}

/// A box with random fills and centres of fill, two materials, and a volume of its own.
Scene border_scene(double volume) {
  Scene scene;
  scene.grid = make_box(4, 3, 2, 0.5, {1, 2, 3});
  scene.materials = {scene_solid(1e6, 0.3, 1000), scene_solid(1e5, 0.4, 300)};
  VoxelGrid& grid = scene.grid;
  grid.volume = volume;
  scene.material = Array<int32_t>(grid.voxel_count());
  scene.pinned = Array<uint8_t>(grid.node_count());
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0.02, 1);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    grid.fill(v) = unit(random);
    const double place[3] = {unit(random), unit(random), unit(random)};
    for (int c = 0; c < 8; ++c) {
      grid.shape_mean(v, c) = 1;
      for (int d = 0; d < 3; ++d) grid.shape_mean(v, c) *= c >> d & 1 ? place[d] : 1 - place[d];
    }
  }
  return scene;
}

double total_mass(const Scene& scene) {
  double sum = 0;
  for (int64_t n = 0; n < scene.mass.rows(); ++n) sum += scene.mass(n);
  return sum;
}

TEST(Scene, MassOfABoxIsDensityTimesVolumeWithItsCentreInTheMiddle) {
  const Scene scene = test::box_scene(4, 3, 5, 0.1, scene_solid(1, 0.3, 700));
  EXPECT_NEAR(total_mass(scene), 700 * 60 * 1e-3, 1e-12);
  double moment[3] = {};
  for (int64_t n = 0; n < scene.mass.rows(); ++n)
    for (int d = 0; d < 3; ++d) moment[d] += scene.mass(n) * scene.grid.rest(n, d);
  EXPECT_NEAR(moment[0] / 42, 0.2, 1e-14);
  EXPECT_NEAR(moment[1] / 42, 0.15, 1e-14);
  EXPECT_NEAR(moment[2] / 42, 0.25, 1e-14);
}

TEST(Scene, MassIsDensityTimesTheVolumeOfTheAssetWhateverTheFill) {
  Scene scene = border_scene(2.345);
  finish_scene(scene);
  EXPECT_NEAR(total_mass(scene), 1000 * 2.345, 1e-10);
}

TEST(Scene, MassOfEachNodeIsTheScatteredShareOfItsVoxels) {
  Scene scene = border_scene(0);
  scene.material(3) = scene.material(11) = 1;
  finish_scene(scene);
  std::vector<double> mass(size_t(scene.grid.node_count()), 0.0);
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    for (int c = 0; c < 8; ++c)
      mass[size_t(scene.grid.corners(v, c))] += (scene.material(v) ? 300 : 1000) * 0.125 *
                                                scene.grid.fill(v) * scene.grid.shape_mean(v, c);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    EXPECT_NEAR(scene.mass(n), mass[size_t(n)], 1e-12);
}

void expect_weights(const Scene& scene, int64_t voxel, double xy, double yz, double zx,
                    double xyz) {
  EXPECT_DOUBLE_EQ(scene.variance(voxel, 0), xy);
  EXPECT_DOUBLE_EQ(scene.variance(voxel, 1), yz);
  EXPECT_DOUBLE_EQ(scene.variance(voxel, 2), zx);
  EXPECT_DOUBLE_EQ(scene.variance(voxel, 3), xyz);
}

TEST(Scene, VarianceWeightTellsSolidSheetAndStrip) {
  const Material m = scene_solid(2.6, 0.3, 1);  // mu = 1
  const double mean = (1 + 1.3) / 2, sheet = 2.6 / (2 * 0.91), strip = 1.3;
  for (const auto& [nx, ny, nz, c] : {std::tuple{2, 2, 2, mean},
                                      {3, 4, 2, mean},
                                      {3, 4, 1, sheet},
                                      {1, 2, 2, sheet},
                                      {5, 1, 1, strip},
                                      {1, 1, 5, strip},
                                      {1, 1, 1, strip}}) {
    const Scene scene = test::box_scene(nx, ny, nz, 0.1, m);
    for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) expect_weights(scene, v, c, c, c, c);
  }
}

TEST(Scene, PartlyFilledThinVoxelsScaleThePatternsOfTheirThinAxes) {
  VoxelGrid grid = make_box(3, 3, 1, 0.1);
  grid.fill.fill(0.5);
  const Scene sheet = test::scene_of(grid, scene_solid(2, 0, 1));  // every weight is 1
  for (int64_t v = 0; v < 9; ++v) expect_weights(sheet, v, 1, 0.25, 0.25, 0.25);
  VoxelGrid bar = make_box(1, 4, 1, 0.1);
  bar.fill.fill(0.5);
  const Scene strip = test::scene_of(bar, scene_solid(2, 0, 1));
  for (int64_t v = 0; v < 4; ++v) expect_weights(strip, v, 0.25, 0.25, 0.25, 0.25);
  VoxelGrid block = make_box(2, 2, 2, 0.1);
  block.fill.fill(0.5);
  const Scene thick = test::scene_of(block, scene_solid(2, 0, 1));
  for (int64_t v = 0; v < 8; ++v) expect_weights(thick, v, 1, 1, 1, 1);
}

TEST(Scene, WithoutTheTermTheWeightsAreZero) {
  const Scene scene = test::box_scene(2, 2, 2, 0.1, scene_solid(1, 0.3, 1), Hourglass::kOff);
  for (int64_t v = 0; v < 8; ++v) expect_weights(scene, v, 0, 0, 0, 0);
}

TEST(Scene, InconsistentScenesAreRejected) {
  const Scene good = border_scene(1);
  const auto expect_rejected = [&](const char* what, auto change) {
    Scene scene = good;
    change(scene);
    EXPECT_THROW(finish_scene(scene), Error) << what;
  };
  // the scene itself is accepted
  Scene copy = good;
  EXPECT_NO_THROW(finish_scene(copy));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  // the grid
  expect_rejected("empty grid", [](Scene& s) { s.grid = VoxelGrid{}; });
  expect_rejected("edge", [](Scene& s) { s.grid.h = 0; });
  expect_rejected("fill", [](Scene& s) { s.grid.fill = Array<double>(1); });
  expect_rejected("shape means", [](Scene& s) { s.grid.shape_mean = Array<double>(24, 7); });
  expect_rejected("node table", [](Scene& s) { s.grid.voxels = Array<int32_t>(3, 8); });
  // materials and pins
  expect_rejected("material of voxels", [](Scene& s) { s.material = Array<int32_t>(5); });
  expect_rejected("material index", [](Scene& s) { s.material(7) = 2; });
  expect_rejected("negative index", [](Scene& s) { s.material(7) = -1; });
  expect_rejected("no material", [](Scene& s) { s.materials.clear(); });
  expect_rejected("bad material", [](Scene& s) { s.materials[1].poisson = 0.5; });
  expect_rejected("pins", [](Scene& s) { s.pinned = Array<uint8_t>(5); });
  // time, gravity and colliders
  expect_rejected("time step", [](Scene& s) { s.dt = 0; });
  expect_rejected("time step", [](Scene& s) { s.dt = kNan; });
  expect_rejected("gravity", [](Scene& s) { s.gravity[1] = kNan; });
  expect_rejected("normal", [](Scene& s) { s.colliders = {half_space({0, 2, 0}, 0, 0.5)}; });
  expect_rejected("offset", [](Scene& s) { s.colliders = {half_space({0, 1, 0}, kNan, 0.5)}; });
  expect_rejected("friction", [](Scene& s) { s.colliders = {half_space({0, 1, 0}, 0, -0.1)}; });
}

TEST(State, StartsAtRestWithARigidMotionAboutTheCentreOfMass) {
  Scene scene = border_scene(1);
  finish_scene(scene);
  const StartMotion motion{{1, -2, 3}, {0.5, 0.25, -4}};
  const State state = initial_state(scene, motion);
  EXPECT_EQ(state.x, scene.grid.rest);
  EXPECT_EQ(state.steps, 0);
  EXPECT_TRUE(state.x_before.empty());
  double momentum[3] = {};
  for (int64_t n = 0; n < scene.mass.rows(); ++n)
    for (int d = 0; d < 3; ++d) momentum[d] += scene.mass(n) * state.v(n, d);
  for (int d = 0; d < 3; ++d)
    EXPECT_NEAR(momentum[d], total_mass(scene) * motion.velocity[d], 1e-9);
  // v_a - v_b = spin x (x_a - x_b)
  const double r[3] = {state.x(9, 0) - state.x(0, 0), state.x(9, 1) - state.x(0, 1),
                       state.x(9, 2) - state.x(0, 2)};
  EXPECT_NEAR(state.v(9, 0) - state.v(0, 0), 0.25 * r[2] + 4 * r[1], 1e-13);
  EXPECT_NEAR(state.v(9, 1) - state.v(0, 1), -4 * r[0] - 0.5 * r[2], 1e-13);
  EXPECT_NEAR(state.v(9, 2) - state.v(0, 2), 0.5 * r[1] - 0.25 * r[0], 1e-13);
}

TEST(State, PinnedNodesStandStillAndAnUnfinishedSceneIsRejected) {
  Scene scene = border_scene(1);
  EXPECT_THROW(initial_state(scene), Error);
  scene.pinned(4) = 1;
  finish_scene(scene);
  const State state = initial_state(scene, {{1, 1, 1}, {1, 1, 1}});
  for (int d = 0; d < 3; ++d) EXPECT_EQ(state.v(4, d), 0);
  EXPECT_NE(state.v(5, 0), 0);
}

TEST(Scene, RefusesBrokenNumbersAndIndices) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  // a finished scene with contact points is spoilt and finished again
  const auto refused = [](const std::function<void(Scene&)>& change) {
    Scene scene = border_scene(0);
    scene.surface.voxel = Array<int32_t>(2);
    scene.surface.weights = Array<double>(2, 8);
    scene.surface.area = Array<double>(2);
    scene.surface.position = Array<double>(2, 3);
    finish_scene(scene);
    change(scene);
    EXPECT_THROW(finish_scene(scene), Error);
  };
  // numbers that are not finite
  for (const double bad : {nan, HUGE_VAL, -HUGE_VAL}) {
    refused([&](Scene& s) { s.grid.fill(1) = bad; });
    refused([&](Scene& s) { s.grid.shape_mean(1, 2) = bad; });
    refused([&](Scene& s) { s.grid.rest(1, 2) = bad; });
    refused([&](Scene& s) { s.grid.volume = bad; });
    refused([&](Scene& s) { s.surface.weights(1, 2) = bad; });
    refused([&](Scene& s) { s.surface.area(1) = bad; });
    refused([&](Scene& s) { s.surface.position(1, 2) = bad; });
  }
  // values without a meaning
  refused([](Scene& s) { s.grid.fill(1) = 0; });
  refused([](Scene& s) { s.grid.h = 1e-310; });  // no mass is left
  refused([](Scene& s) { s.surface.area(1) = -1; });
  // indices out of range
  for (const int index : {-2, 1000}) {
    refused([&](Scene& s) { s.grid.corners(1, 2) = index; });
    refused([&](Scene& s) { s.grid.voxels(1, 2) = index; });
    refused([&](Scene& s) { s.surface.voxel(1) = index; });
  }
  refused([](Scene& s) { s.surface.area = Array<double>(1); });
}

}  // namespace
}  // namespace elastogen
