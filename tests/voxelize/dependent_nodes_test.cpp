// SPDX-License-Identifier: Apache-2.0
#include "voxelize/dependent_nodes.hpp"

#include "core/error.hpp"
#include "tests/voxelize/shapes.hpp"
#include "voxelize/levelled_distance.hpp"

#include <limits>

namespace elastogen::test {
namespace {

constexpr double kFarAway = std::numeric_limits<double>::infinity();

Border below(double place, int axis = 0) {
  Border border{{-kFarAway, -kFarAway, -kFarAway}, {kFarAway, kFarAway, kFarAway}, 0, true};
  border.upper[size_t(axis)] = place;
  return border;
}

Border above(double place, int axis = 0) {
  Border border{{-kFarAway, -kFarAway, -kFarAway}, {kFarAway, kFarAway, kFarAway}, 0, true};
  border.lower[size_t(axis)] = place;
  return border;
}

Border ball_border(const Vec3& centre, double radius) {
  return {centre, centre, radius, false};
}

struct Held {
  Voxelized body;
  DependentNodes nodes;
};

Held hold(const Surface& surface, const std::vector<Border>& borders, const Vec3& align, double h) {
  VoxelizeOptions options;
  options.h = h;
  for (size_t d = 0; d < 3; ++d) options.align[d] = align[d];
  options.borders = borders;
  Held held{voxelize(surface, options), {}};
  const Array<uint8_t> pinned(held.body.grid.node_count());
  held.nodes = dependent_nodes(held.body.grid, borders, held.body.cut, pinned);
  return held;
}

double filled_volume(const VoxelGrid& grid) {
  double sum = 0;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) sum += grid.fill(v);
  return sum * std::pow(grid.h, 3);
}

/// Fills a field of the nodes and says how far dependent nodes are from what it was.
double deviation(const Held& held, const std::function<double(int64_t)>& field) {
  Array<double> u(held.body.grid.node_count(), 3);
  for (int64_t n = 0; n < u.rows(); ++n)
    for (int d = 0; d < 3; ++d) u(n, d) = (d + 1) * field(n);
  const Array<double> wanted = u;
  for (int64_t i = 0; i < held.nodes.count(); ++i) std::fill_n(u.row(held.nodes.node(i)), 3, 7.0);
  held.nodes.fill(u.data());
  double most = 0;
  for (int64_t k = 0; k < u.size(); ++k)
    most = std::max(most, std::abs(u.data()[k] - wanted.data()[k]));
  return most;
}

TEST(FreePart, HasTheVolumeAndTheCentroidBesideTwoPlanesInAnyPlaceOfTheGrid) {
  for (const double offset : {1e-4, 0.2, 0.5, 0.9999}) {
    const std::vector<Border> borders = {below(0.01), above(0.99)};
    const Held held = hold(box({0, 0, 0}, {1, 0.2, 0.2}).surface(), borders,
                           {0.01 - offset * 0.05, 0.02, 0.02}, 0.05);
    const VoxelGrid& grid = held.body.grid;
    EXPECT_NEAR(filled_volume(grid), 0.98 * 0.04, 1e-8);
    EXPECT_NEAR(grid.volume, 0.98 * 0.04, 1e-8);
    Vec3 centre = {};
    for (int64_t v = 0; v < grid.voxel_count(); ++v)
      for (int c = 0; c < 8; ++c)
        for (size_t d = 0; d < 3; ++d)
          centre[d] += grid.fill(v) * std::pow(grid.h, 3) * grid.shape_mean(v, c) *
                       grid.rest(grid.corners(v, c), int(d)) / (0.98 * 0.04);
    EXPECT_NEAR(centre[0], 0.5, 1e-7);
    EXPECT_NEAR(centre[1], 0.1, 1e-7);
    EXPECT_NEAR(centre[2], 0.1, 1e-7);
  }
}

TEST(FreePart, KnowsFacesOfABodyThatLieWithinItsBox) {
  Soup soup = box({0, 0, 0}, {1, 0.2, 0.2});
  soup.add(box({-0.5, 0.6, 0}, {-0.3, 0.8, 0.2}));
  for (const double offset : {0.1, 0.3, 0.7, 0.9}) {
    const Held held = hold(soup.surface(), {below(-0.42), below(0.01), above(0.99)},
                           {0.01 - offset * 0.05, 0.02, 0.02}, 0.05);
    EXPECT_NEAR(filled_volume(held.body.grid), 0.98 * 0.04, 1e-8);
    EXPECT_NEAR(held.body.grid.volume, 0.98 * 0.04, 1e-8);
  }
}

TEST(FreePart, OfARoundBodyBehindAPlaneIsACap) {
  const Surface ball = sphere(0.5, {}, 5).surface();
  const double whole = filled_volume(hold(ball, {}, {}, 0.1).body.grid);
  for (const double place : {-0.48, -0.27, -0.03, 0.14}) {
    const double height = 0.5 + place,
                 cap = height * height * (1.5 - height) / (4 * std::pow(0.5, 3));
    const double free = filled_volume(hold(ball, {below(place)}, {}, 0.1).body.grid);
    EXPECT_NEAR(free / whole, 1 - cap, 5e-4) << place;
  }
}

TEST(FreePart, CountsWhatTwoBordersHoldOnce) {
  const std::vector<Border> borders = {below(0.33), below(0.33, 1), below(0.31)};
  const Held held = hold(box({0, 0, 0}, {1, 1, 1}).surface(), borders, {0, 0, 0}, 0.1);
  EXPECT_NEAR(filled_volume(held.body.grid), 0.67 * 0.67, 1e-7);
}

TEST(FreePart, OfABallIsThatOfItsPointsInTheLattice) {
  const Held held = hold(box({0, 0, 0}, {1, 1, 1}).surface(), {ball_border({0.52, 0.47, 0.5}, 0.3)},
                         {0, 0, 0}, 0.1);
  EXPECT_NEAR(filled_volume(held.body.grid), 1 - 4.0 / 3 * 3.14159265 * 0.027, 1e-3);
}

TEST(DependentNodes, FollowFieldsThatAreLinearAndZeroOnThePlane) {
  for (const double offset : {1e-4, 0.05, 0.3, 0.7, 0.92, 0.9999}) {
    const Held held = hold(box({0, 0, 0}, {1, 0.4, 0.4}).surface(), {below(0.2)},
                           {0.2 - offset * 0.1, 0.03, 0.04}, 0.1);
    EXPECT_EQ(held.nodes.empty(), false);
    const VoxelGrid& grid = held.body.grid;
    const auto field = [&](int64_t n) {
      return (grid.rest(n, 0) - 0.2) * (1 + 3 * grid.rest(n, 1));
    };
    EXPECT_LT(deviation(held, field), 1e-13);
    for (int64_t i = 0; i < held.nodes.count(); ++i) {
      ASSERT_EQ(held.nodes.parents(i).rows, 1);
      EXPECT_LT(held.nodes.weights(i)(0), 0.1 + 1e-9);
      EXPECT_GT(held.nodes.weights(i)(0), -9 - 1e-9);
    }
  }
}

TEST(DependentNodes, FollowTheLevelledDistanceOfABall) {
  const Border border = ball_border({0.5, 0.52, 0.47}, 0.23);
  const Held held = hold(box({0, 0, 0}, {1, 1, 1}).surface(), {border}, {0, 0, 0}, 0.1);
  std::vector<int32_t> voxels;
  for (const BorderVoxel& at : held.body.cut) voxels.push_back(at.voxel);
  const LevelledDistance levelled(held.body.grid, border, voxels);
  EXPECT_LT(deviation(held, [&](int64_t n) { return levelled(int32_t(n)); }), 1e-13);
}

TEST(DependentNodes, AreMirrorImagesInAMirroredScene) {
  const Surface surface = box({0, 0, 0}, {1, 0.4, 0.4}).surface();
  const Held left = hold(surface, {below(0.23)}, {0, 0, 0}, 0.1);
  const Held right = hold(surface, {above(0.77)}, {0, 0, 0}, 0.1);
  ASSERT_EQ(left.nodes.count(), right.nodes.count());
  const auto sum_of_weights = [](const Held& held, bool mirrored) {
    std::map<std::array<int32_t, 3>, double> sums;
    for (int64_t i = 0; i < held.nodes.count(); ++i) {
      const int32_t* at = held.body.grid.node_coord.row(held.nodes.node(i));
      double& sum = sums[{mirrored ? 10 - at[0] : at[0], at[1], at[2]}];
      for (int64_t k = 0; k < held.nodes.weights(i).rows; ++k) sum += held.nodes.weights(i)(k);
    }
    return sums;
  };
  const auto a = sum_of_weights(left, false), b = sum_of_weights(right, true);
  for (const auto& [at, sum] : a) {
    ASSERT_TRUE(b.contains(at));
    EXPECT_NEAR(sum, b.at(at), 1e-12);
  }
}

TEST(DependentNodes, AreNoneBesideABorderJustOutsideOfTheBody) {
  const Surface surface = box({0, 0, 0}, {1, 0.2, 0.2}).surface();
  VoxelizeOptions options;
  options.h = 0.07;
  const VoxelGrid alone = voxelize(surface, options).grid;
  options.borders = {below(-0.001), ball_border({1.2, 0.1, 0.1}, 0.1999)};
  const Voxelized beside = voxelize(surface, options);
  EXPECT_TRUE(beside.cut.empty());
  EXPECT_EQ(beside.grid.fill, alone.fill);
  EXPECT_EQ(beside.grid.shape_mean, alone.shape_mean);
  EXPECT_EQ(beside.grid.corners, alone.corners);
}

TEST(DependentNodes, HoldAFaceOfTheBodyThatTheGridDoesNotFit) {
  const Held held = hold(box({0, 0, 0}, {1, 0.2, 0.2}).surface(), {below(0)}, {0.02, 0, 0}, 0.05);
  const VoxelGrid& grid = held.body.grid;
  EXPECT_EQ(held.nodes.count(), 25);
  EXPECT_LT(deviation(held, [&](int64_t n) { return grid.rest(n, 0); }), 1e-13);
}

TEST(DependentNodes, FoldIsTheTransposeOfFill) {
  const DependentNodes nodes({1, 4}, {0, 2, 3}, {0, 2, 2}, {0.25, -3, 0.5});
  double u[15] = {}, g[15] = {}, left = 0, right = 0;
  for (int k = 0; k < 15; ++k) u[k] = k * k % 7, g[k] = k * 5 % 11;
  double filled_u[15], folded[15];
  std::copy_n(u, 15, filled_u);
  std::copy_n(g, 15, folded);
  nodes.fill(filled_u);
  nodes.fold(folded);
  for (int k = 0; k < 15; ++k) left += filled_u[k] * g[k], right += u[k] * folded[k];
  EXPECT_DOUBLE_EQ(left, right);
  EXPECT_EQ(folded[3], 0);
  EXPECT_EQ(folded[14], 0);
}

TEST(DependentNodes, RefuseListsThatDoNotFit) {
  EXPECT_THROW(DependentNodes({1}, {0, 1}, {1}, {1}), Error);
  EXPECT_THROW(DependentNodes({1}, {0, 2}, {0}, {1}), Error);
  EXPECT_THROW(DependentNodes({2, 1}, {0, 0, 0}, {}, {}), Error);
}

}  // namespace
}  // namespace elastogen::test
